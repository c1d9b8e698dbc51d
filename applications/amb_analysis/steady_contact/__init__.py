"""Steady rub: synchronous states in contact, their stability, and the control forces that free a rotor."""
