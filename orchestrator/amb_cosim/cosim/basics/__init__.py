"""Basics of the co-simulation layer: errors, choices, the time grid, interruption, the cache."""
