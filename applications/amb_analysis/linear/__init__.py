"""Linear models of components, of the machine, and of its sampled loop."""
