"""Kernels as C99: reads LLVM assembly and translates it to C."""
