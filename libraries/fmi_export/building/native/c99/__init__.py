"""Kernels as C99: LLVM assembly read, and written again as C."""
