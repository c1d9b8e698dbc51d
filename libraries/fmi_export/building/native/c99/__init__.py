"""Kernels as C99: LLVM assembly is read, and written again as C."""
