"""The master algorithm, in Python and compiled, and the settled motion of a system."""
