"""What every room of the co-simulation layer uses: errors, choices, the time grid, interruption, the cache."""
