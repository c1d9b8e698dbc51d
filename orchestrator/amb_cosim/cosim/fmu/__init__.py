"""One FMU: its description and libraries, and its instance as the master uses it."""
