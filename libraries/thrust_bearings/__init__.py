"""Axial magnetic bearings: force of a two-sided thrust disc and eddy currents in solid iron."""
