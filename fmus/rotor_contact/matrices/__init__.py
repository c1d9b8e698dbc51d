"""Matrices of the exact motion over a step, a half, a quarter and so on, and when they are built."""
