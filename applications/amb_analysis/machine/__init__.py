"""A levitated rotor for analyses: its `Machine`, bearing forces, responses and coupled loop."""
