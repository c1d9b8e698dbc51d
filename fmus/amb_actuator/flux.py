"""Flux density of a coil pair in its air gap, saturation of the iron, and the resulting pull."""

from __future__ import annotations

import math

from fmi_export.jit import kernel

MU_0 = 4e-7 * math.pi  # H/m, permeability of vacuum as the thesis uses it


@kernel
def flux_density(turns: float, current: float, distance: float) -> float:
    """Return the flux density (T) of a current (A) across a gap (m), without saturation: b = mu_0 N I / distance."""
    return MU_0 * turns * current / distance


@kernel
def limited_flux(b: float, b_sat: float, width: float) -> tuple[float, float]:
    """Return the flux density B (T) limited by saturation of the iron, and dB/db.

    B = b                                                     up to b_1 = (1 - width) b_sat
    B = b - (b - b_1)^2 / (4 width b_sat)                     up to b_2 = (1 + width) b_sat
    B = b_sat                                                 beyond

    B and its slope are continuous. Below the knee b_1 nothing changes, so the linearisation at the operating point is
    still that of (2.8, 2.9). The limit is reached at b_2, not just approached.

    Parameters
    ----------
    b
        Flux density without saturation, >= 0 (T).
    b_sat
        Saturation flux density (T).
    width
        Half-width of the knee relative to b_sat, 0 to 1.
    """
    beyond = b - (1.0 - width) * b_sat
    if beyond <= 0.0:
        return b, 1.0
    if b >= (1.0 + width) * b_sat:
        return b_sat, 0.0
    return b - beyond * beyond / (4.0 * width * b_sat), 1.0 - beyond / (2.0 * width * b_sat)


@kernel
def pull_of_flux(flux: float, pole_area: float, half_angle: float) -> float:
    """Return the pull P = B^2 A_e cos(phi)/mu_0 (N) of a coil pair: two pole faces at +-phi, each B^2 A_e/(2 mu_0)."""
    return flux * flux * pole_area * math.cos(half_angle) / MU_0


def saturation_flux(force: float, pole_area: float, half_angle: float) -> float:
    """Return the B_sat (T) that limits the pull of a coil pair to `force` (N); this is the inverse of `pull_of_flux`.

    Raises
    ------
    ValueError
        If the force is not positive.
    """
    if not force > 0.0:
        raise ValueError(f"force = {force:g} N is not allowed; it must be > 0 N")
    return math.sqrt(MU_0 * force / (pole_area * math.cos(half_angle)))
