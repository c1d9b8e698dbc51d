"""Model of the rotor for analyses of sampled control, with all modes, of any frequency, that affect the samples.

Sampled control, which holds its currents over a sample time T, excites every mode and mistakes a fast mode for a slow
one. Consider a mode of frequency omega and damping ratio zeta, with the displacements phi_f where forces act and phi_s
at sensors, per unit of modal mass. Its response to a harmonic sequence of such currents is at most about

    phi_f phi_s/omega^2  2/(1 - exp(-zeta omega T))  1/sqrt(1 + (omega/omega_b)^2)                  (1)

The first factor is the mode's static displacement. The second is its largest amplification, which its decay within a
sample limits. The third is the gain of amplifiers with bandwidth omega_b at the frequency of the mode. All modes up to
a frequency are retained, and so are higher modes whose response exceeds `SMALL` times the motion of the whole rotor at
half the sample rate. In (1), zeta is at least `LEAST_DAMPING`: the material limits the response of a mode even if the
rotor file states no damping. The other modes are out of reach of the control. They act through their residual shapes,
all of which are retained (`free_rotor.residual_modes`). A residual shape combines several modes and is not a mode
itself: it is damped so strongly that samples see only its static displacement.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from rotor_analysis.assembly import assemble
from rotor_analysis.free_rotor import free_rotor, residual_modes
from rotor_analysis.inertia import lacks_inertia
from rotor_analysis.modal_reduction import ROUNDING, ShapeSpace, reduce_to_shapes
from rotor_analysis.reduced_rotor import force_nodes
from rotor_analysis.reduction import Reduction, unreduced
from rotor_analysis.rotor import Rotor

LEAST_DAMPING = 1e-4  # damping ratio of steel without joints, in (1)
RESIDUAL = math.sqrt(0.5)  # damping ratio of residual shapes, with which they do not resonate
SMALL = 0.03  # (1) of a neglected mode over the displacement at half the sample rate


@dataclass(frozen=True)
class Sampling:
    """How sampled control acts on a rotor.

    time
        Time T between samples (s).
    forces, sensors
        Nodes at which the control acts, and nodes at which it reads displacements.
    bandwidth
        Bandwidth omega_b (rad/s) of a first-order lag between the held currents and the forces; infinite without a lag.
    """

    time: float
    forces: tuple[int, ...]
    sensors: tuple[int, ...]
    bandwidth: float = math.inf


def sampled_rotor(rotor: Rotor, sampling: Sampling, highest: float) -> Reduction:
    """Return the free rotor with all modes that sampled control can notice.

    Parameters
    ----------
    rotor
        Description of the rotor; its `reduction` is ignored.
    sampling
        How the control acts.
    highest
        Frequency (rad/s) up to which all modes are retained, even above half the sample rate.
    """
    full = assemble(rotor)
    if lacks_inertia(full.M, full.K):
        return unreduced(full)
    free, half, damping = free_rotor(full), math.pi / sampling.time, rotor.damping
    omega, forces, sensors = free.frequencies, free.rows(sampling.forces), free.rows(sampling.sensors)
    phi = np.abs(free.modes(len(omega))[:, 2:])
    ratios = damping.ratios(len(omega)) + 0.5 * (damping.stiffness * omega + damping.loss_factor)
    decay = -np.expm1(-np.maximum(ratios, LEAST_DAMPING) * omega * sampling.time)
    lag = np.hypot(1.0, omega / sampling.bandwidth) / np.hypot(1.0, half / sampling.bandwidth)
    size = free.sizes(sorted({*forces, *sensors}), half).min()
    answers = 2.0 * phi[forces].max(axis=0) * phi[sensors].max(axis=0)
    retained = (answers > SMALL * size * omega**2 * decay * lag) | (omega <= highest)
    order, count = np.argsort(~retained, kind="stable"), int(retained.sum())
    ordered = replace(free, mu=free.mu[order], shapes=free.shapes[:, order])
    nodes = force_nodes(rotor)
    residual = residual_modes(ordered, count, nodes, ROUNDING)
    momenta = full.M[::2, ::2] @ residual.shapes
    added = (momenta * (2.0 * RESIDUAL * residual.frequencies)) @ momenta.T
    damped = replace(full, C=full.C + np.kron(added, np.eye(2)))
    return reduce_to_shapes(damped, ShapeSpace(ordered, count, residual), nodes)
