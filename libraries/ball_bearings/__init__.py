"""Ball bearings from their catalogue data: Hertz contact of balls and grooves, loads of the balls, stiffness."""
