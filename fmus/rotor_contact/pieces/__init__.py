"""Motion over a piece of a step by the matrices: contact forces, the first event, and energies."""
