"""The rotor for analyses of sampled control: the modes that the samples see, whatever their frequency.

Control that acts by forces held over a sample T excites every mode, and sees a fast one as a slow one. A mode of
frequency omega and damping ratio zeta, with the displacement phi per unit of modal mass where forces act and sensors
are, answers a harmonic sequence of such forces by at most about

    phi^2/omega^2  2/(1 - exp(-zeta omega T))                                                       (1)

which is its static displacement times the amplification of its decay within a sample. All modes up to half the sample
rate are retained, and those above with more than `SMALL` of what the rotor moves by at half the sample rate. The others
act by their residual shapes, all of which are retained (`free_rotor.residual_modes`).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rotor_analysis.assembly import assemble
from rotor_analysis.free_rotor import free_rotor, residual_modes
from rotor_analysis.inertia import lacks_inertia
from rotor_analysis.modal_reduction import ROUNDING, ShapeSpace, reduce_to_shapes
from rotor_analysis.reduced_rotor import force_nodes
from rotor_analysis.reduction import Reduction, unreduced
from rotor_analysis.rotor import Rotor

SMALL = 0.1  # (1) of a neglected mode over the displacement at half the sample rate


def sampled_rotor(rotor: Rotor, sample_time: float, highest: float) -> Reduction:
    """Return the free rotor with all modes that sampled control can notice.

    Parameters
    ----------
    rotor
        Its description; its `reduction` is ignored.
    sample_time
        T (s).
    highest
        Frequency (rad/s) up to which all modes are retained, even above half the sample rate.
    """
    full = assemble(rotor)
    if lacks_inertia(full.M, full.K):
        return unreduced(full)
    free, half = free_rotor(full), math.pi / sample_time
    omega, nodes = free.frequencies, force_nodes(rotor)
    rows = free.rows(tuple(sorted({*nodes, *rotor.sensor_nodes})))
    phi = np.abs(free.modes(len(omega))[rows, 2:]).max(axis=0)
    damping = rotor.damping
    ratios = damping.ratios(len(omega)) + 0.5 * (damping.stiffness * omega + damping.loss_factor)
    decay = -np.expm1(-ratios * omega * sample_time)
    size = free.sizes(rows, half).min()
    seen = 2.0 * phi**2 > SMALL * size * omega**2 * decay
    retained = seen | (omega <= max(half, highest))
    order = np.argsort(~retained, kind="stable")
    count = int(retained.sum())
    ordered = replace(free, mu=free.mu[order], shapes=free.shapes[:, order])
    space = ShapeSpace(ordered, count, residual_modes(ordered, count, nodes, ROUNDING))
    return reduce_to_shapes(full, space, nodes)
