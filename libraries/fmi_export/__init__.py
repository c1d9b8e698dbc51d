"""Code that running FMUs share: variable tables, records, kernels and the FMI slave; `building` builds FMUs."""
