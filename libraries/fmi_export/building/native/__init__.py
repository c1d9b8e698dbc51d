"""The native flavour: builds an FMU from a model's kernels for five platforms; the FMU runs without Python."""
