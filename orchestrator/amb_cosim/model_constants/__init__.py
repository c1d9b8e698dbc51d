"""Constants of the plant, the actuator and the controller of a rotor, computed before a run."""
