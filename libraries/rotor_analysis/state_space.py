"""State space of the rotor at one spin speed (python-control), and its motion after a change of unbalance."""

from __future__ import annotations

from collections.abc import Mapping

import control
import numpy as np

from fmi_export.model import Array
from rotor_analysis.checks import require
from rotor_analysis.response import steady_state, unbalance_vector
from rotor_analysis.supported_rotor import SupportedRotor


def state_space(
    rotor_model: SupportedRotor, Omega: float, forces: tuple[int, ...], observed: tuple[int, ...]
) -> control.StateSpace:
    """Return the state space with states (q, q'), from forces (N) to displacements (m), x and y of each node.

    q'' = M^-1 (f - (C + Omega G) q' - K q)

    Parameters
    ----------
    rotor_model
        The rotor on its bearings; the condensed model has few states.
    Omega
        Spin speed (rad/s), constant.
    forces, observed
        Node numbers of the forces and of the displacements.

    Raises
    ------
    ValueError
        If a node does not exist or Omega is not finite.
    """
    require(bool(np.isfinite(Omega)), "Omega", f"{Omega} rad/s", "finite")
    model = rotor_model.model.at(Omega)
    n = model.size
    identity, zero = np.eye(n), np.zeros((n, n))
    inverse = np.linalg.inv(model.M)
    A = np.block([[zero, identity], [-inverse @ model.K, -inverse @ (model.C + Omega * model.G)]])
    B = np.vstack([np.zeros((n, 2 * len(forces))), inverse @ rotor_model.force_at(forces)])
    C = np.hstack([rotor_model.displacement_of(observed), np.zeros((2 * len(observed), n))])
    return control.ss(
        A,
        B,
        C,
        np.zeros((len(C), B.shape[1])),
        inputs=[f"f_{axis}{node}" for node in forces for axis in "xy"],
        outputs=[f"{axis}{node}" for node in observed for axis in "xy"],
    )


def unbalance_step(
    rotor_model: SupportedRotor,
    Omega: float,
    before: Mapping[int, complex],
    after: Mapping[int, complex],
    times: Array,
    observed: tuple[int, ...],
) -> Array:
    """Return the motion after the unbalance changes at t = 0, without contact.

    The new steady motion plus the free motion from the difference of the old and new states; exact at the given times.

    Parameters
    ----------
    rotor_model
        The rotor on its bearings.
    Omega
        Spin speed (rad/s); theta = Omega t.
    before, after
        Node number to complex unbalance (kg m); the rotor moves steadily with `before` until t = 0.
    times
        Times (s), evenly spaced, from 0.
    observed
        Node numbers whose motion is returned.

    Returns
    -------
    array, shape (len(observed), 2, len(times))
        x and y (m).

    Raises
    ------
    ValueError
        If a node does not exist or the times do not start at 0.
    """
    times = np.asarray(times, dtype=np.float64)
    require(len(times) > 1 and times[0] == 0.0, "times", f"{times[:3].tolist()} s ...", "two or more, from 0 s")
    old, new = (steady_state(rotor_model.model, Omega, unbalance_vector(rotor_model, u)) for u in (before, after))
    difference = np.concatenate([(old - new).real, (1j * Omega * (old - new)).real])
    free = control.initial_response(
        state_space(rotor_model, Omega, (), observed), times, difference, squeeze=False
    ).outputs
    steady = (rotor_model.displacement_of(observed) @ np.outer(new, np.exp(1j * Omega * times))).real
    return (steady + free).reshape(len(observed), 2, -1)
