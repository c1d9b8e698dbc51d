"""The library that stands before PythonFMU's in FMUs of flavour python, and refuses what that would not survive."""
