"""Scenarios of a levitated rotor: their files, what they mean as experiments, what a run of one needs, and the run."""
