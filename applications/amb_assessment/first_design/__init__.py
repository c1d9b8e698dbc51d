"""First design of a machine in magnetic bearings from mass, length and speed, as files."""
