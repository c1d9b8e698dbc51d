"""Assemblies: all components of a system in a single FMU, such as rotor, magnetic bearings and controller."""
