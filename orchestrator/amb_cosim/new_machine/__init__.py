"""Files to start from: a first design of a machine in magnetic bearings from mass, length and speed."""
