"""The native flavour: builds an FMU that needs no Python from a model's kernels, for five platforms."""
