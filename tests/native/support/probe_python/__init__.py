"""Kernels that cannot do without Python, and some that look as if they could not."""
