"""Radial active magnetic bearings: force law and current limits of two bearings with two axes each."""
