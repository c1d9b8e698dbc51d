"""Variable table of the controller, and the positions that its kernels read.

First positions are looked up in the table; what repeats for each axis, sensor or harmonic follows its declaration.
"""

from __future__ import annotations

from fmi_export.variables import interface
from rolac_controller.parameters import PARAMETERS
from rolac_controller.signals import FAULTS, INPUTS, OUTPUTS

INTERFACE = interface(PARAMETERS, INPUTS, OUTPUTS)

# Parameters
SAMPLE_TIME = INTERFACE.parameter_index("sample_time")
DERIVATIVE_TIME = INTERFACE.parameter_index("derivative_time")
DIRECT = INTERFACE.parameter_index("pid.direct")
GAINS = INTERFACE.parameter_index("mb1.k_b_x")
N_GAINS = 9
K_B, C_B, K_INTEGRAL, K_S, K_I, I_MIN, I_MAX, K_P, K_D = range(N_GAINS)
HARMONIC = INTERFACE.parameter_index("harmonic1.order")
HARMONIC_PARAMETERS = 2
ORDER, POWER = range(HARMONIC_PARAMETERS)
WEIGHT = INTERFACE.parameter_index("s1.weight")

MODE = INTERFACE.parameter_index("rolac.mode")
ALPHA = INTERFACE.parameter_index("rolac.alpha")
MIN_SPEED = INTERFACE.parameter_index("rolac.min_speed")
FORCE_LIMIT = INTERFACE.parameter_index("rolac.force_limit")
EXTRAPOLATE = INTERFACE.parameter_index("rolac.extrapolate")
CHECK_SENSORS = INTERFACE.parameter_index("rolac.check_sensors")
STEADINESS = INTERFACE.parameter_index("olac.steadiness")
UPDATES = INTERFACE.parameter_index("olac.updates")
CONTACT_SOURCE = INTERFACE.parameter_index("contact.source")
CONTACT_AWARE = INTERFACE.parameter_index("contact.aware")
CONTACT_LEAD = INTERFACE.parameter_index("contact.lead")
CLEARANCE = INTERFACE.parameter_index("contact.clearance")
THRESHOLD = INTERFACE.parameter_index("contact.threshold")

MULTI = INTERFACE.parameter_index("identification.multi")
FORCE_SCALE = INTERFACE.parameter_index("identification.force_scale")
AVERAGE = INTERFACE.parameter_index("identification.average")
MAX_DRIFT = INTERFACE.parameter_index("identification.max_drift")
MAX_CONDITION = INTERFACE.parameter_index("identification.max_condition")

PRESET = INTERFACE.parameter_index("chain.preset")
NOISE = INTERFACE.parameter_index("chain.noise")
FILTER = INTERFACE.parameter_index("chain.filter")
ADC = INTERFACE.parameter_index("chain.adc")
DAC = INTERFACE.parameter_index("chain.dac")
DELAY = INTERFACE.parameter_index("chain.delay")
NOISE_RMS = INTERFACE.parameter_index("chain.noise_rms")
SEED = INTERFACE.parameter_index("chain.seed")
CUTOFF = INTERFACE.parameter_index("chain.cutoff")
SENSITIVITY = INTERFACE.parameter_index("chain.sensitivity")
ADC_BITS = INTERFACE.parameter_index("chain.adc_bits")
ADC_RANGE = INTERFACE.parameter_index("chain.adc_range")
DAC_BITS = INTERFACE.parameter_index("chain.dac_bits")
DAC_RANGE = INTERFACE.parameter_index("chain.dac_range")
AMPLIFIER_GAIN = INTERFACE.parameter_index("chain.amplifier_gain")
SCALE = INTERFACE.parameter_index("s1.scale")
PLANE_Z = INTERFACE.parameter_index("plane1.z")
PLANE_OFFSET = INTERFACE.parameter_index("plane1.offset")

# Inputs
SENSOR = INTERFACE.input_index("s1")
OMEGA = INTERFACE.input_index("Omega")
THETA = INTERFACE.input_index("theta")
ENABLE = INTERFACE.input_index("rolac_enable")
IDENTIFY = INTERFACE.input_index("identify")
CONTACT_STATE = INTERFACE.input_index("contact_state")
SHOWN_HARMONIC = INTERFACE.input_index("shown_harmonic")
SETPOINT = INTERFACE.input_index("mb1.set_x")
FAULT = INTERFACE.input_index("s1.fault_dead")
FAULT_INPUTS = len(FAULTS)
DEAD, STUCK, OFFSET, BURST = range(FAULT_INPUTS)

# Outputs
AXIS_OUTPUTS = 3
CURRENT, FORCE, FORCE_PHASE = range(AXIS_OUTPUTS)
AMPLITUDE = INTERFACE.output_index("amplitude.s1")
PHASE = AMPLITUDE + 1  # amplitude and phase alternate
DISPLACEMENTS = INTERFACE.output_index("harmonic1.displacement")
FORCES = DISPLACEMENTS + 1  # as do these
ACTIVE = INTERFACE.output_index("rolac_active")
VALID = INTERFACE.output_index("window_valid")
STATUS = INTERFACE.output_index("rolac_status")
FORCE_LIMITED = INTERFACE.output_index("rolac_limited")
EXTRAPOLATED = INTERFACE.output_index("h_extrapolated")
CURRENT_LIMITED = INTERFACE.output_index("current_limited")
SUSPECT_SENSOR = INTERFACE.output_index("suspect_sensor")
CONTACT_SHARE = INTERFACE.output_index("mb1.contact_share")
TABLE_ROWS = INTERFACE.output_index("table_rows")
STAGE = INTERFACE.output_index("identification_state")
ERROR = INTERFACE.output_index("identification_error")
PROGRESS = INTERFACE.output_index("identification_progress")
IDENTIFIED_SPEED = INTERFACE.output_index("identification_speed")
CONDITION = INTERFACE.output_index("condition_number")
RECEPTANCE = INTERFACE.output_index("r.s1.mb1_x.re")
