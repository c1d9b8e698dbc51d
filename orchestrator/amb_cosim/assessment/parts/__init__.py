"""The questions of an assessment, each a module with a function `answer`."""
