"""Sampled controller of the magnetic bearings: PID per axis, recursive Fourier transform, ROLAC."""

PACKAGES = ("rolac_controller", "signal_chain", "fmi_export")  # whose code the kernels need
