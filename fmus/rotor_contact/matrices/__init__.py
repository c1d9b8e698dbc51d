"""Matrices of the exact motion over a step, half a step, a quarter and so on, and the schedule of building them."""
