"""The guard of FMUs of flavour python: the library in front of PythonFMU's, which refuses what that cannot handle."""
