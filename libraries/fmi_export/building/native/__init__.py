"""The native flavour: from a model's kernels to an FMU that needs no Python, for five platforms."""
