"""The guard in FMUs of flavour python: a library that rejects calls that PythonFMU's library cannot handle."""
