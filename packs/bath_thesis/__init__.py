"""A. G. Abulrub, Modelling and control of contact in magnetic bearing/flexible rotor systems, PhD, Bath, 2006.

The pack contains the thesis's rig as rotors, its runs as scenarios, its statements and printed numbers, and fits to
these numbers.
"""
