"""The parts of an assessment, each a module with a function `answer`."""
