"""The matrices and seals of a rotor, matrix products, and solutions of linear equations."""
