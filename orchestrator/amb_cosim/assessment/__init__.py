"""May this machine run? What a machine file describes, judged by criteria that are data, on one page.

machine_file   the form of a machine file, which names rotor, bearings, controller, speeds and loads
subject        the machine of a file as analyses need it: rotor, linear loop, parameters
expressions    formulas of criteria, evaluated without Python
criteria       criteria of standards and users: formula, limits, source, and whether that was read
findings       what was computed, and the verdict on it
feedback       force of bearings over displacement, with hold, delay and amplifier
response       synchronous response of rotor and bearings, its peaks and their amplification
coupled        the sampled loop with seals, cross coupling and other values of its constants
parts          the questions, each answered by a module
assess         all of them, one after the other, none of which ends the others
page           one HTML page; `pdf` prints it
"""
