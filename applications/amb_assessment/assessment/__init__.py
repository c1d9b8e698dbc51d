"""Assesses a machine file by criteria that are data, on one page.

machine_file   the format of a machine file: rotor, bearings, controller, speeds and loads
assessed_machine  the machine of a file, with the data of the file
stages         its stages, in linear models and in co-simulation
expressions    formulas of criteria, evaluated without Python
criteria       criteria of standards and users: formula, limits, source, and whether it was read
quantities     what analyses compute, and criteria may limit
findings       verdicts on quantities
analyses       parts of an assessment, each a module
assess         runs all parts in sequence; a failed part does not end the others
page           an HTML page; `pdf` prints it
"""
