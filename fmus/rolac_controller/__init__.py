"""Sampled controller of the magnetic bearings: PID per axis, recursive Fourier transform, ROLAC."""
