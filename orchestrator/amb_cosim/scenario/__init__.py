"""Scenarios of a levitated rotor: their files, experiments, and the preparation and execution of their runs."""
