"""Magnetic bearings and their control without a simulation: bearing design, the sampled loop, receptance tables."""
