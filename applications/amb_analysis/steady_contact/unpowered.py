"""Receptances of the journals of an unpowered rotor. Displacements are relative to the retainers, which may be on
mounts.

    z_j - h_j = -sum_k (R_jk + delta_jk H_j) F_k,    H_j = 1/(k_j - m_j omega^2 + i omega d_j)         (1)

for forces -F on the rotor and F on the housings. R is the receptance of the rotor with its seals, without magnets. For
a mount, k and d are the means of its stiffness and damping along x and y.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from amb_analysis.linear.components import frequency_response
from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.steady_contact.forward_loop import Complex, forward_rotor
from amb_cosim.results.component_names import PLANT


def relative_receptances(source: LinearSource, Omega: float, sites: Sequence[str]) -> Callable[[float], Complex]:
    """Return the matrix R + H of (1) (m/N) as a function of the whirl frequency (rad/s), which must not be 0.

    Parameters
    ----------
    source
        Source of the linear models of a run.
    Omega, sites
        Spin speed (rad/s), and names of the retainers.
    """
    rotor, p = forward_rotor(source, Omega, sites), source.parameters(PLANT)

    def mount(site: str, omega: float) -> complex:
        mass = p[f"{site}.housing_mass"]
        if not mass:
            return 0.0
        k, d = (0.5 * (p[f"{site}.mount_{kind}_x"] + p[f"{site}.mount_{kind}_y"]) for kind in ("stiffness", "damping"))
        return 1.0 / (k - mass * omega**2 + 1j * omega * d)

    def relative(omega: float) -> Complex:
        return frequency_response(rotor, 1j * omega) + np.diag([mount(site, omega) for site in sites])

    return relative
