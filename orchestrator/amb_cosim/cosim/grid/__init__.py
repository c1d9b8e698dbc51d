"""The times of a run: its communication points, and its inputs over time."""
