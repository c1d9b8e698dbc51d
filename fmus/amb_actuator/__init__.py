"""Active magnetic bearings, two axes each, and a thrust magnet: force laws, saturation, amplifiers, faults."""
