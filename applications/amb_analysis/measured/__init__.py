"""Measured data of a machine (frequency responses, modes and time records), read from files into SI units.

records      types for a channel, a frequency response, a list of modes, a record over time
blows        blows of a hammer in a record, and the spectra of the blocks after them
quality      sentences about coherence and blows
estimates    frequency responses and coherence from records of inputs and outputs
units        SI units of measured channels
files        reads a file of any form: `.uff`, `.unv`, `.mat`, `.npz`, tables, and results of runs
modal_fit    natural frequencies, damping and shapes from frequency responses
convention   sign and time convention of measured responses
deviation    how far two frequency responses differ: FRAC, MAC, pairs of modes
response_fit  parameters from responses whose scatter is estimated from the data
least_squares  parameters with confidence intervals, or an error if the data do not determine them
"""
