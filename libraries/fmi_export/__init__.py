"""Shared code of running FMUs: variable tables, records, kernels and the FMI slave; `building` builds FMUs."""
