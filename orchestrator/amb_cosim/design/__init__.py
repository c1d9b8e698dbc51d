"""From a rotor to the constants of its plant, actuator and controller, and the design of its magnetic bearings."""
