"""How the flat state and scratch arrays of the controller are laid out."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import views
from fmi_export.model import Array
from rolac_controller import fourier, identification, inverse, notch, olac, pid, sensors, stored, supervision
from rolac_controller.adaptation import N_U
from rolac_controller.names import N_AXES, N_BEARINGS, N_HARMONICS, N_SENSORS

# State: flags, PID of each axis, currents computed last, synchronous forces, shares of contact, then each part's own
# memory, the window, and the table of H in use, whose size depends on the constants.
STARTED, LIMITED = 0, 1
AXES = 2
CURRENTS = AXES + N_AXES * pid.N_MEMORY
FORCES = CURRENTS + N_AXES
CONTACT = FORCES + N_HARMONICS * N_U
SENSORS = CONTACT + N_BEARINGS
SUPERVISION = SENSORS + sensors.N_MEMORY
OLAC = SUPERVISION + supervision.N_MEMORY
IDENTIFICATION = OLAC + olac.N_MEMORY
WINDOW = IDENTIFICATION + identification.N_MEMORY
TABLE = WINDOW + fourier.N_WINDOW

# Scratch: measured displacements, their components, forces of the axes, orders and powers of the harmonics, step of the
# forces, H or R, the rest.
COMPONENTS = N_SENSORS
TURNING = COMPONENTS + N_HARMONICS * fourier.N_Q
ORDERS = TURNING + N_AXES
POWERS = ORDERS + N_HARMONICS
CHANGE = POWERS + N_HARMONICS
MATRIX = CHANGE + N_U
REST = MATRIX + inverse.N_MATRIX
N_WORK = REST + max(inverse.N_SCRATCH, notch.N_SCRATCH)


class State(NamedTuple):
    """Views into the state, by their uses."""

    flags: Array
    axes: Array
    currents: Array
    forces: Array
    contact: Array
    sensors: Array
    supervision: Array
    olac: Array
    identification: Array
    window: Array
    table: Array


class Scratch(NamedTuple):
    """Views into the scratch array, by their uses; `inversion` is `matrix` and `rest` together."""

    measured: Array
    q: Array
    u: Array
    orders: Array
    powers: Array
    change: Array
    matrix: Array
    rest: Array
    inversion: Array


def n_state(constants: Array) -> int:
    """Size of the state of a controller with these constants."""
    return TABLE + stored.size_of(constants)


@views
def state_of(state: Array) -> State:
    """The state by its uses."""
    return State(
        state[:AXES],
        state[AXES:CURRENTS],
        state[CURRENTS:FORCES],
        state[FORCES:CONTACT],
        state[CONTACT:SENSORS],
        state[SENSORS:SUPERVISION],
        state[SUPERVISION:OLAC],
        state[OLAC:IDENTIFICATION],
        state[IDENTIFICATION:WINDOW],
        state[WINDOW:TABLE],
        state[TABLE:],
    )


@views
def scratch_of(work: Array) -> Scratch:
    """The scratch array by its uses."""
    return Scratch(
        work[:COMPONENTS],
        work[COMPONENTS:TURNING],
        work[TURNING:ORDERS],
        work[ORDERS:POWERS],
        work[POWERS:CHANGE],
        work[CHANGE:MATRIX],
        work[MATRIX:REST],
        work[REST:],
        work[MATRIX:],
    )
