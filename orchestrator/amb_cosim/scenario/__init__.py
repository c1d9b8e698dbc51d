"""Scenarios of a levitated rotor: files, experiments, preparation and execution of runs."""
