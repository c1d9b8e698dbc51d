"""What the three FMUs share: variable tables, units, the FMI slave and the FMU builder."""
