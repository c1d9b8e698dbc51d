"""Synchronous receptance of the levitated rotor: what ROLAC inverts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fmi_export.model import Array
from rotor_contact.assembly import assemble, on_bearings
from rotor_contact.reduction import msdc
from rotor_contact.rotor import Rotor
from rotor_contact.rotor_file import load_rotor


def receptance(
    speeds: Array, k_b: float = 1e6, c_b: float = 5000.0, rotor: Rotor | None = None
) -> NDArray[np.complex128]:
    """Complex receptance R of the reduced rotor at synchronous frequency: Q = Q_0 + R U (5.6).

    R = S [-Omega^2 M + j Omega (C + Omega G) + K]^-1 B, with q = Re[Q exp(j theta)], u = Re[U exp(j theta)]

    Parameters
    ----------
    speeds
        Spin speeds Omega (rad/s), shape (n,).
    k_b, c_b
        Net stiffness (N/m) and damping (N s/m) of both bearings under PID control.
    rotor
        A rotor description; the rig of the thesis by default.

    Returns
    -------
    array, shape (n, 8, 4), complex
        m/N; sensors s1 .. s8 by forces mb1.x, mb1.y, mb2.x, mb2.y.
    """
    rotor = (rotor or load_rotor()).on_equal_bearings(k_b, c_b)
    full = on_bearings(assemble(rotor, "diagonal"), rotor)
    reduction = msdc(full, rotor.planes.master)
    m = reduction.model
    sensors = reduction.right[full.rows(rotor.planes.sensors)]
    B = np.eye(m.size)[:, m.rows(rotor.bearing_nodes)]
    return np.array(
        [
            sensors @ np.linalg.solve(-(Omega**2) * m.M + 1j * Omega * (m.C + Omega * m.G) + m.K, B)
            for Omega in np.asarray(speeds, dtype=np.float64)
        ]
    )
