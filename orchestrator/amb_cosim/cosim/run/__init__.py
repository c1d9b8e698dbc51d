"""A run of a plan: start, step, save, resume, isolate, label."""
