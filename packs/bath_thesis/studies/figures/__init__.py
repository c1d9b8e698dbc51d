"""Figures of the studies beside this folder."""
