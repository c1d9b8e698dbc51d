"""How does a run share the computer? Its processes and threads, and how they are interrupted."""
