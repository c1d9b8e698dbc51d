"""What the FMUs share when they run: variable tables, records, kernels and the FMI slave; `building` builds FMUs."""
