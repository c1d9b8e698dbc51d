"""Radial active magnetic bearings, two axes each: force laws, saturation, amplifiers, faults."""
