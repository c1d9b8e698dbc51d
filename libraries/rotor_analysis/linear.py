"""The rotor at one spin speed as a linear system of python-control, and what happens when an unbalance changes."""

from __future__ import annotations

from collections.abc import Mapping

import control
import numpy as np

from fmi_export.model import Array
from rotor_analysis.response import steady_state, unit_force
from rotor_analysis.rotor import require
from rotor_analysis.supported import Supported


def state_space(support: Supported, Omega: float, forces: tuple[int, ...], seen: tuple[int, ...]) -> control.StateSpace:
    """States (q, q'), inputs the forces in x and y at the nodes `forces` (N), outputs x and y of the nodes `seen` (m).

    q'' = M^-1 (f - (C + Omega G) q' - K q)

    Parameters
    ----------
    support
        The rotor on its bearings; condensed, it has few states and is quick.
    Omega
        Spin speed (rad/s), constant.
    forces, seen
        Node numbers.

    Raises
    ------
    ValueError
        If a node does not exist or Omega is not finite.
    """
    require(bool(np.isfinite(Omega)), "Omega", f"{Omega} rad/s", "finite")
    model = support.model
    n = model.size
    identity, zero = np.eye(n), np.zeros((n, n))
    inverse = np.linalg.inv(model.M)
    A = np.block([[zero, identity], [-inverse @ model.K, -inverse @ (model.C + Omega * model.G)]])
    B = np.vstack([np.zeros((n, 2 * len(forces))), inverse @ support.force_at(forces)])
    C = np.hstack([support.displacement_of(seen), np.zeros((2 * len(seen), n))])
    return control.ss(
        A,
        B,
        C,
        np.zeros((len(C), B.shape[1])),
        inputs=[f"f_{axis}{node}" for node in forces for axis in "xy"],
        outputs=[f"{axis}{node}" for node in seen for axis in "xy"],
    )


def unbalance_step(
    support: Supported,
    Omega: float,
    before: Mapping[int, complex],
    after: Mapping[int, complex],
    times: Array,
    seen: tuple[int, ...],
) -> Array:
    """Motion after the unbalance changes at t = 0, without contact (Figs 3.8, 3.9).

    The new steady motion plus the free motion that carries the old state over; both exact at the times asked for.

    Parameters
    ----------
    support
        The rotor on its bearings.
    Omega
        Spin speed (rad/s); theta = Omega t.
    before, after
        Node number to complex unbalance (kg m); the rotor moves steadily with `before` until t = 0.
    times
        Times (s), evenly spaced, from 0.
    seen
        Node numbers to look at.

    Returns
    -------
    array, shape (len(seen), 2, len(times))
        x and y (m).

    Raises
    ------
    ValueError
        If a node does not exist or the times do not start at 0.
    """
    times = np.asarray(times, dtype=np.float64)
    require(len(times) > 1 and times[0] == 0.0, "times", f"{times[:3].tolist()} s ...", "two or more, from 0 s")
    old, new = (steady_state(support.model, Omega, unit_force(support, u)) for u in (before, after))
    difference = np.concatenate([(old - new).real, (1j * Omega * (old - new)).real])
    free = control.initial_response(state_space(support, Omega, (), seen), times, difference, squeeze=False).outputs
    steady = (support.displacement_of(seen) @ np.outer(new, np.exp(1j * Omega * times))).real
    return (steady + free).reshape(len(seen), 2, -1)
