"""Runs the reference experiments that an FMU contains."""
