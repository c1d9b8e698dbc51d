"""A system of FMUs and an experiment with it: files, checks, and the plan on the time grid."""
