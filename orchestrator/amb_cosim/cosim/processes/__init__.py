"""Processes and threads of a run, and how they are interrupted."""
