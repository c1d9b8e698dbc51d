"""The master algorithm, in Python and compiled, and the motion a system settles to."""
