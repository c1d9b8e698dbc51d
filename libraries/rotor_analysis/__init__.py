"""Finite-element model of a rotor and its analysis without a simulation: modes, responses, receptance."""
