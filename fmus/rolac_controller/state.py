"""The controller's memory: views into its state, and into its work array."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.records import record, size_of
from rolac_controller.complex_numbers import Complex
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
from rolac_controller.records import Records
from rolac_controller.sensor_check import CHECK_MEMORY
from rolac_controller.sensors import SensorMemory, sensor_memory_of, sensor_memory_size
from rolac_controller.sizes import Sizes, sizes_of

HEAD = record(
    ("started", "f8"),  # 1 after the first sample
    ("current_limited", "f8"),  # 1 if a current was at its limit at the last sample
)
# What was found at this sample; flags are 0 or 1.
FINDINGS = record(
    ("delta_theta", "f8"),  # angle since the sample before (rad)
    ("window_valid", "f8"),
    ("suspect_sensor", "f8"),
    ("in_contact", "f8"),
    ("status", "f8"),  # rolac_status
    ("extrapolated", "f8"),
    ("force_limited", "f8"),
)
N_HEAD, N_FINDINGS, N_PID, N_CHECK = (size_of(r) for r in (HEAD, FINDINGS, PID_MEMORY, CHECK_MEMORY))


class State(NamedTuple):
    """The state; the table of receptances in use follows it in the array.

    head
        Record HEAD, in an array of one.
    axes
        Records PID_MEMORY, shape (n_axes,).
    currents
        Computed last, shape (n_axes,) (A).
    U
        Synchronous forces, shape (N_HARMONICS, n_axes) (N).
    contact_shares
        Shape (n_axes // 2,).
    checks
        Records CHECK_MEMORY, shape (n_sensors,).
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


class Work(NamedTuple):
    """The work array.

    findings
        Record FINDINGS, in an array of one.
    displacements, Q
        At this sample: measured, shape (n_sensors,), and synchronous, shape (N_HARMONICS, n_sensors) (m).
    u
        Synchronous forces and test force now, shape (n_axes,) (N).
    delta_U, R, H, svd
        Intermediate results of the adaptation: shapes (n_axes,), (n_sensors, n_axes), (n_axes, n_sensors).
    inverse_S, E
        Of the notch: shapes (n_axes, n_axes), (n_axes,).
    """

    findings: Records
    displacements: Array
    Q: Complex
    u: Array
    delta_U: Complex
    R: Complex
    H: Complex
    svd: SvdWork
    inverse_S: Complex
    E: Complex


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
    )


@views
def state_of(state: Array, sizes: Sizes) -> State:
    """Return views into the state."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    head, rest = state[:N_HEAD].view(HEAD), state[N_HEAD:]
    axes, rest = rest[: n_axes * N_PID].view(PID_MEMORY), rest[n_axes * N_PID :]
    currents, rest = rest[:n_axes], rest[n_axes:]
    size = 2 * N_HARMONICS * n_axes
    U, rest = rest[:size].view(np.complex128).reshape(N_HARMONICS, n_axes), rest[size:]
    shares, rest = rest[: n_axes // 2], rest[n_axes // 2 :]
    sensors, rest = sensor_memory_of(rest, n_sensors), rest[sensor_memory_size(n_sensors) :]
    checks, rest = rest[: n_sensors * N_CHECK].view(CHECK_MEMORY), rest[n_sensors * N_CHECK :]
    olac, rest = olac_memory_of(rest, n_sensors), rest[olac_memory_size(n_sensors) :]
    identification, rest = identification_memory_of(rest, sizes), rest[identification_memory_size(sizes) :]
    window = window_of(rest, n_sensors)
    return State(head, axes, currents, U, shares, sensors, checks, olac, identification, window)


@views
def work_of(work: Array, sizes: Sizes) -> Work:
    """Return views into the work array."""
    n_axes, n_sensors = sizes.n_axes, sizes.n_sensors
    findings, rest = work[:N_FINDINGS].view(FINDINGS), work[N_FINDINGS:]
    displacements, rest = rest[:n_sensors], rest[n_sensors:]
    u, rest = rest[:n_axes], rest[n_axes:]
    size = 2 * N_HARMONICS * n_sensors
    Q, rest = rest[:size].view(np.complex128).reshape(N_HARMONICS, n_sensors), rest[size:]
    delta_U, rest = rest[: 2 * n_axes].view(np.complex128), rest[2 * n_axes :]
    E, rest = rest[: 2 * n_axes].view(np.complex128), rest[2 * n_axes :]
    size = 2 * n_axes * n_sensors
    R, rest = rest[:size].view(np.complex128).reshape(n_sensors, n_axes), rest[size:]
    H, rest = rest[:size].view(np.complex128).reshape(n_axes, n_sensors), rest[size:]
    svd, rest = svd_work_of(rest, sizes), rest[svd_work_size(sizes) :]
    inverse_S = rest[: 2 * n_axes * n_axes].view(np.complex128).reshape(n_axes, n_axes)
    return Work(findings, displacements, Q, u, delta_U, R, H, svd, inverse_S, E)


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
        + 2 * n_axes * (2 * n_sensors + n_axes)
        + svd_work_size(sizes)
    )
