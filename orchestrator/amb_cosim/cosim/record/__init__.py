"""Recorded signals: the recorder, labels, warnings, NetCDF."""
