"""A. G. Abulrub, Modelling and control of contact in magnetic bearing/flexible rotor systems, PhD, Bath, 2006.

The rig of that thesis as rotors, its runs as scenarios, its statements and printed numbers, and fits to them.
"""
