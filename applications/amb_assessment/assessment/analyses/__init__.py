"""The parts of an assessment, each a module with a function `result_of`."""
