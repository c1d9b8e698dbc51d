"""Analyses of a machine: linear models, steady contact, studies."""
