"""Forces on the rotor without contact, and its acceleration under them."""
