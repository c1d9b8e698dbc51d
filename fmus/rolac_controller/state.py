"""Views into the controller's state and work array."""

from __future__ import annotations

from typing import NamedTuple

from fmi_export.jit import views
from fmi_export.linear_state import LinearState
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import record, size_of
from rolac_controller.complex_numbers import COMPLEX, REAL, Complex
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.fourier import Window, window_of, window_size
from rolac_controller.identified_receptance import (
    IdentificationMemory,
    identification_memory_of,
    identification_memory_size,
)
from rolac_controller.olac import OlacMemory, olac_memory_of, olac_memory_size
from rolac_controller.pid import PID_MEMORY
from rolac_controller.pseudo_inverse import SvdWork, svd_work_of, svd_work_size
from rolac_controller.receptance_table import table_size
from rolac_controller.records import inputs_size
from rolac_controller.sensor_check import CHECK_MEMORY
from rolac_controller.sizes import Records, Sizes, sizes_of
from signal_chain.readings import N_STREAM, SensorMemory, sensor_memory_of, sensor_memory_size

HEAD = record(
    ("begin", "f8"),  # time of the first sample (s)
    ("n_samples", "f8"),  # samples taken
    ("current_limited", "f8"),  # 1 if a current was at its limit at the last sample
    ("last_time", "f8"),  # of the last step, with a prediction (s)
)
# Results of this sample; flags are 0 or 1.
FINDINGS = record(
    ("delta_theta", "f8"),  # angle since the sample before (rad)
    ("adc_limited", "f8"),
    ("window_valid", "f8"),
    ("suspect_sensor", "f8"),
    ("in_contact", "f8"),
    ("status", "f8"),  # rolac_status
    ("extrapolated", "f8"),
    ("force_limited", "f8"),
)
N_HEAD, N_FINDINGS, N_PID, N_CHECK = (size_of(r) for r in (HEAD, FINDINGS, PID_MEMORY, CHECK_MEMORY))


class State(NamedTuple):
    """The state without the table of receptances in use; this table follows the state in the array.

    head
        Record HEAD, in an array of length 1.
    axes
        Records PID_MEMORY, shape (n_axes,).
    currents
        The currents computed last, shape (n_axes,) (A).
    U
        Synchronous forces, shape (N_HARMONICS, n_axes) (N).
    contact_shares
        Share of time in contact for each bearing, shape (n_axes // 2,).
    checks
        Records CHECK_MEMORY, shape (n_sensors,).
    last_displacements
        Displacements at the last step, if a prediction is used, shape (n_sensors,) (m).
    """

    head: Records
    axes: Records
    currents: Array
    U: Complex
    contact_shares: Array
    sensors: SensorMemory
    checks: Records
    olac: OlacMemory
    identification: IdentificationMemory
    window: Window
    last_displacements: Array


class Work(NamedTuple):
    """The work array.

    findings
        Record FINDINGS, in an array of length 1.
    displacements, Q
        Measured displacements, shape (n_sensors,), and synchronous displacements, shape (N_HARMONICS, n_sensors), at
        this sample (m).
    u
        Present sum of synchronous forces and test force, shape (n_axes,) (N).
    delta_U, R, H, svd
        Intermediate results of the adaptation: delta_U has the shape (n_axes,), R (n_sensors, n_axes), and H (n_axes,
        n_sensors).
    C, inverse_S, E
        Quantities of the notch: C has the shape (n_axes, n_sensors), inverse_S (n_axes, n_axes), and E (n_axes,).
    inputs
        Flat array of the inputs of the step, with predicted values.
    """

    findings: Records
    displacements: Array
    Q: Complex
    u: Array
    delta_U: Complex
    R: Complex
    H: Complex
    svd: SvdWork
    C: Complex
    inverse_S: Complex
    E: Complex
    inputs: Array


@views
def state_size(sizes: Sizes) -> int:
    """Return the size of the state without the table."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    return (
        N_HEAD
        + n_axes * (N_PID + 1)
        + 2 * N_HARMONICS * n_axes
        + n_axes // 2
        + sensor_memory_size(n_sensors)
        + n_sensors * N_CHECK
        + olac_memory_size(n_sensors)
        + identification_memory_size(sizes)
        + window_size(n_sensors)
        + n_sensors
    )


@views
def state_of(state: Array, sizes: Sizes) -> State:
    """Return views into the state."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    axes = N_HEAD
    currents = axes + n_axes * N_PID
    U = currents + n_axes
    shares = U + 2 * N_HARMONICS * n_axes
    sensors = shares + n_axes // 2
    checks = sensors + sensor_memory_size(n_sensors)
    olac = checks + n_sensors * N_CHECK
    identification = olac + olac_memory_size(n_sensors)
    window = identification + identification_memory_size(sizes)
    return State(
        part(state, 0, HEAD, 1),
        part(state, axes, PID_MEMORY, n_axes),
        part(state, currents, REAL, n_axes),
        part(state, U, COMPLEX, (N_HARMONICS, n_axes)),
        part(state, shares, REAL, n_axes // 2),
        sensor_memory_of(state, sensors, n_sensors),
        part(state, checks, CHECK_MEMORY, n_sensors),
        olac_memory_of(state, olac, n_sensors),
        identification_memory_of(state, identification, sizes),
        window_of(state, window, n_sensors),
        part(state, window + window_size(n_sensors), REAL, n_sensors),
    )


@views
def work_of(work: Array, sizes: Sizes) -> Work:
    """Return views into the work array."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    displacements = N_FINDINGS
    Q = displacements + n_sensors
    u = Q + 2 * N_HARMONICS * n_sensors
    delta_U = u + n_axes
    R = delta_U + 2 * n_axes
    H = R + 2 * n_sensors * n_axes
    svd = H + 2 * n_sensors * n_axes
    C = svd + svd_work_size(sizes)
    inverse_S = C + 2 * n_axes * n_sensors
    return Work(
        part(work, 0, FINDINGS, 1),
        part(work, displacements, REAL, n_sensors),
        part(work, Q, COMPLEX, (N_HARMONICS, n_sensors)),
        part(work, u, REAL, n_axes),
        part(work, delta_U, COMPLEX, n_axes),
        part(work, R, COMPLEX, (n_sensors, n_axes)),
        part(work, H, COMPLEX, (n_axes, n_sensors)),
        svd_work_of(work, svd, sizes),
        part(work, C, COMPLEX, (n_axes, n_sensors)),
        part(work, inverse_S, COMPLEX, (n_axes, n_axes)),
        part(work, inverse_S + 2 * n_axes * n_axes, COMPLEX, n_axes),
        part(work, inverse_S + 2 * n_axes * (n_axes + 1), REAL, inputs_size(sizes)),
    )


def n_state(constants: Array) -> int:
    """Return the size of the state of a controller with these constants."""
    return state_size(sizes_of(constants)) + table_size(constants)


def n_work(constants: Array) -> int:
    """Return the size of the work array of a controller with these constants."""
    sizes = sizes_of(constants)
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    return (
        N_FINDINGS
        + n_sensors * (1 + 2 * N_HARMONICS)
        + 5 * n_axes
        + 2 * n_axes * (3 * n_sensors + n_axes)
        + svd_work_size(sizes)
        + inputs_size(sizes)
    )


def linear_state(constants: Array) -> LinearState:
    """Return the positions of the state's linear part: PID, currents, filters, and stored displacements."""
    sizes = sizes_of(constants)
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    U = N_HEAD + n_axes * (N_PID + 1)
    sensors = U + 2 * N_HARMONICS * n_axes + n_axes // 2
    end, begin = sensors + sensor_memory_size(n_sensors), state_size(sizes) - n_sensors
    rows = (N_HEAD, U), (sensors + N_STREAM, end), (begin, begin + n_sensors)
    return LinearState(rows, unless=("rolac_enable", "identify"))
