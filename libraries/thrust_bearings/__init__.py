"""Axial magnetic bearings: force of a two-sided thrust disc, eddy currents in solid iron, the loop of the axis."""
