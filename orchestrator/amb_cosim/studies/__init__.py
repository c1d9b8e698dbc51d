"""Computations behind the commands that run no scenario: modes, tables, studies, cost of contact."""
