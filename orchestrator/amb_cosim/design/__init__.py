"""Constants of plant, actuator and controller from a rotor, and the design of its magnetic bearings."""
