"""An FMU: its description and libraries, and its instance for the master."""
