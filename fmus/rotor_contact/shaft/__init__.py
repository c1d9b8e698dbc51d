"""The matrices and seals of a rotor, and products and solutions with them."""
