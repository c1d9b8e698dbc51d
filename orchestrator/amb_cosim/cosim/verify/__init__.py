"""Runs of the reference experiments that an FMU carries."""
