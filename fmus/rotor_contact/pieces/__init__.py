"""Motion over a piece of a step by these matrices: contact forces, the first event, energies."""
