"""A whole step at a constant speed as one product."""
