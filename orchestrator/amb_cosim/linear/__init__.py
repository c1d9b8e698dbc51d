"""Linear models: of each component, of the machine they make together, and of its sampled loop."""
