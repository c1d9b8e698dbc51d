"""Sampled linear controller: any number of states, measured signals and demands, matrices that depend on the speed."""

PACKAGES = ("linear_controller", "signal_chain", "fmi_export")  # whose code the kernels need
