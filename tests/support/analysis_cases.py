"""Rotors with exact closed forms: their shafts are massless or rigid."""

import numpy as np

from rotor_analysis.assembly import Matrices, assemble, on_bearings
from rotor_analysis.parts import Bearing, Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import Shaft
from rotor_analysis.supported_rotor import supported_rotor
from rotor_analysis.undamped import undamped_modes

L, D, E = 0.8, 0.03, 2.1e11
MASS, I_D, I_P = 12.0, 0.05, 0.09
STEEL = {"youngs_modulus": 2.1e11, "density": 7800.0, "poissons_ratio": 0.3}


def one_plane(matrix):
    """Return x translations and slopes of an assembled matrix."""
    return matrix[::2, ::2]


def tensor(direct, cross=0.0):
    """Isotropic, with skew cross-coupling: [[direct, cross], [-cross, direct]]."""
    return ((direct, cross), (-cross, direct))


def disc_between(left, right, *more, i_d=I_D, i_p=I_P):
    """A disc in the middle of a weightless shaft with bearings at its ends, and `more` of them."""
    shaft = Shaft((0.0, L / 2, L), (D,), E, 1e-12, 0.3, theory="rayleigh")
    return Rotor("disc", shaft, (Body("disc", 2, MASS, i_d, i_p),), (left, right, *more))


NOTHING = tensor(0.0)


def rigid(stiffness, damping=NOTHING, **inertia):
    """A disc on a rigid shaft in two equal bearings.

    Translation: MASS r'' + 2 c r' + 2 k r = 0; tilt: I_D a'' - i Omega I_P a' + (c a' + k a) L^2 / 2 = 0.
    """
    bearings = [Bearing(name, node, stiffness, damping) for name, node in (("left", 1), ("right", 3))]
    return supported_rotor(disc_between(*bearings, **inertia), planes=(1, 3))


def jeffcott(k_bearing=1e7, damping=0.0):
    """A disc on an elastic shaft in equal bearings, damped at the disc: two degrees of freedom, MASS, c, `spring`."""
    held = [Bearing(name, node, tensor(k_bearing)) for name, node in (("left", 1), ("right", 3))]
    return supported_rotor(disc_between(*held, Bearing("damper", 2, NOTHING, tensor(damping))), planes=(2,))


def spring(k_bearing=1e7):
    """Stiffness (N/m) of the shaft 48 E I / L^3 in series with two bearings."""
    shaft = 48.0 * E * np.pi * D**4 / 64.0 / L**3
    return 1.0 / (1.0 / shaft + 0.5 / k_bearing)


def clamped(model):
    """`model` with its first node held, translations and slopes."""
    M, C, R, G, K = (matrix[4:, 4:] for matrix in (model.M, model.C, model.R, model.G, model.K))
    return Matrices(M, C, R, G, K, {node: (x - 4, y - 4) for node, (x, y) in model.translations.items() if node > 1})


def natural_frequencies(rotor, count):
    """Natural frequencies (rad/s) among the first `count` modes of the undamped rotor at rest, ascending."""
    return undamped_modes(on_bearings(assemble(rotor), rotor), rotor, count)[0]
