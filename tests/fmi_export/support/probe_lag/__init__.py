"""A small model with state that the tests of the export build an FMU from."""
