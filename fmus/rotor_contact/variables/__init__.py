"""The interface of the FMU, and its values as records."""
