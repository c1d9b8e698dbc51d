"""The guard of FMUs of flavour python: a library in front of PythonFMU's that rejects calls which it cannot handle."""
