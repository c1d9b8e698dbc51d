"""Radial active magnetic bearings: force law, linearisation and current limits of two bearings with two axes each."""
