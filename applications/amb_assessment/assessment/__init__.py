"""Assesses a machine file by criteria that are data, on one page.

machine_file   the format of a machine file: rotor, bearings, controller, speeds and loads
subject        the machine of a file, and what the file says of it
stages         its stages, in linear models and in co-simulation
expressions    formulas of criteria, evaluated without Python
criteria       criteria of standards and users: formula, limits, source, and whether that was read
findings       what was computed, and the verdict on it
analyses       the questions, each answered by a module
assess         all of them, in sequence, none of which ends the others
page           an HTML page; `pdf` prints it
"""
