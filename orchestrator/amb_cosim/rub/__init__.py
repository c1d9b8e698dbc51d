"""Steady rub: states in which a rotor turns in contact, their stability, and what frees it."""
