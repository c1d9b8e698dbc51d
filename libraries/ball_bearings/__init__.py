"""Ball bearings from their catalogue data: Hertz contact of balls and grooves, ball loads, stiffness."""
