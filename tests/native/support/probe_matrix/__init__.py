"""A small model whose variables are arrays in FMI 3.0."""
