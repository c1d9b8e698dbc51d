"""Sampled linear controller with any number of states, measured signals and demands, and speed-dependent matrices."""

PACKAGES = ("linear_controller", "signal_chain", "fmi_export")  # whose code the kernels need
