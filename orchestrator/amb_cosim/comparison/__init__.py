"""Comparison of runs: summaries in one table, differences of signals, and overlaid figures."""
