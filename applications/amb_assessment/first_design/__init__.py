"""First design of a machine in magnetic bearings, made from mass, length and speed, and written as files."""
