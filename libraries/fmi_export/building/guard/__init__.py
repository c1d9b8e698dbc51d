"""The guard of FMUs of flavour python: the library before PythonFMU's, which rejects calls that it cannot handle."""
