"""Assemblies: all components of a system in one FMU, such as rotor, magnetic bearings and controller."""
