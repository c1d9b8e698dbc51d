"""Recursive open-loop adaptive control: the integral law for the synchronous force (thesis 5.22, 5.23).

docs/theory/synchronous_control.md states the law. If Q = Q_0 + R U and H is computed from this R, the law is U' =
-alpha (U - U_opt). The forces approach the weighted least-squares optimum with the time constant 1/alpha, provided that
1/alpha is much longer than the revolution over which Q is averaged.

While adaptation is not permitted, the forces fade: U' = -fade U. When adaptation resumes, the forces continue from the
remaining values, so they never jump.
"""

from __future__ import annotations

from fmi_export.jit import kernel
from fmi_export.model import Array
from rolac_controller.complex_numbers import Complex, phasor, scaled, squared_magnitude
from rolac_controller.control_loop import N_HARMONICS
from rolac_controller.sizes import Records

ROUNDING = 1e-12
FADED = 1e-6  # N; a smaller fading force is set to zero


@kernel
def integral_step(H: Complex, gain: float, Q: Complex, delta_U: Complex) -> None:
    """Compute the step gain H Q of the integral law (5.22).

    Parameters
    ----------
    H
        Matrix H, shape (n_axes, n_sensors) (N/m).
    gain
        alpha times the sample time; 1 for a full update in one step.
    Q
        Synchronous displacements, shape (n_sensors,) (m).
    delta_U
        Receives the step of the forces U, shape (n_axes,) (N).
    """
    for axis in range(H.shape[0]):
        total = 0j
        for s in range(H.shape[1]):
            total += H[axis, s] * Q[s]
        delta_U[axis] = gain * total


@kernel
def forces_at(U: Complex, harmonics: Records, theta: float, u: Array) -> None:
    """Compute the force u = Re[U exp(j n theta)] of each axis, summed over the harmonics (5.23).

    Parameters
    ----------
    U
        Forces of all harmonics, shape (N_HARMONICS, n_axes) (N).
    harmonics
        Records HARMONIC, shape (N_HARMONICS,); the first order 0 ends the list.
    theta
        Rotor angle (rad).
    u
        Receives the force of each axis, shape (n_axes,) (N).
    """
    u[:] = 0.0
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        rotation = phasor(harmonics[k].order * theta)
        for axis in range(u.shape[0]):
            u[axis] += (U[k, axis] * rotation).real


@kernel
def fade_forces(U: Complex, share: float) -> None:
    """Reduce all forces, shape (N_HARMONICS, n_axes) (N), by the fraction `share`; forces below `FADED` become zero."""
    for k in range(N_HARMONICS):
        for axis in range(U.shape[1]):
            faded = squared_magnitude(U[k, axis]) < FADED * FADED
            U[k, axis] = 0j if faded else scaled(U[k, axis], 1.0 - share)


@kernel
def turn_forces(U: Complex, harmonics: Records, angle: float) -> None:
    """Keep the present forces when the rotor angle jumps by `angle` (rad): U becomes U exp(-j n angle).

    U and `harmonics` are as in `limit_forces`.
    """
    for k in range(N_HARMONICS):
        if harmonics[k].order == 0.0:
            break
        rotation = phasor(-harmonics[k].order * angle)
        for axis in range(U.shape[1]):
            U[k, axis] *= rotation


@kernel
def limit_forces(U: Complex, harmonics: Records, largest: float) -> bool:
    """Scale down an axis's forces if their amplitudes add up to more than `largest`; return whether any is limited.

    The forces are themselves the integrals of the law, so limiting them also prevents wind-up.

    Parameters
    ----------
    U
        Forces of all harmonics, shape (N_HARMONICS, n_axes) (N); changed.
    harmonics
        Records HARMONIC, shape (N_HARMONICS,); the first order 0 ends the list.
    largest
        Largest allowed sum of the amplitudes of an axis (N).
    """
    limited = False
    for axis in range(U.shape[1]):
        total = 0.0
        for k in range(N_HARMONICS):
            if harmonics[k].order == 0.0:
                break
            total += abs(U[k, axis])
        limited = limited or total > (1.0 - ROUNDING) * largest
        if total > largest:
            for k in range(N_HARMONICS):
                U[k, axis] *= largest / total
    return limited
