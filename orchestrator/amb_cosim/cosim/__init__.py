"""Co-simulation of FMI 2.0 FMUs: components, systems, master and recording; it knows FMI and numbers alone."""
