"""Runs side by side: their summaries in one table, how far their signals differ, and figures over each other."""
