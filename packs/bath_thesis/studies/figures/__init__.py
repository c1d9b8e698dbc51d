"""Figures of the studies in the folder above."""
