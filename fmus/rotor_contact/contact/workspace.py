"""Data that the kernels of a step pass to one another."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.model import Array
from fmi_export.parts import part
from fmi_export.records import size_of
from rotor_contact.contact.faces import FACE_INTEGRALS, N_FACE_INTEGRALS
from rotor_contact.contact.site import Sites
from rotor_contact.contact.site_totals import SITE_INTEGRALS
from rotor_contact.forces.dynamics import Motion
from rotor_contact.shaft.linear_solver import Equations
from rotor_contact.variables.energies import ENERGY_INTEGRALS

# At the end of every state z: integrals of energies over time and, for each site and each face, those over the step.
N_INTEGRALS, N_SITE_INTEGRALS = size_of(ENERGY_INTEGRALS), size_of(SITE_INTEGRALS)
N_STAGES = 9


class Stages(NamedTuple):
    """Rows of `Workspace.stages`: states z = (q, v, energy integrals, integrals of sites and faces), and derivatives.

    Each has the shape (2 n + N_INTEGRALS + N_SITE_INTEGRALS n_sites + N_FACE_INTEGRALS n_faces,), where n is the total
    number of degrees of freedom.
    """

    z: Array  # at the beginning of a substep
    z_new: Array  # at its end
    k_1: Array  # derivatives of z and z_new
    k_new: Array
    trial: Array  # state and derivatives of the Runge-Kutta stages in between
    k_2: Array
    k_3: Array
    k_4: Array
    before: Array  # velocities before an impact (m/s)


class Workspace(NamedTuple):
    """Rotor, motion, contact sites, contact equations and integration stages of a step."""

    n: int  # total number of degrees of freedom: m of the shaft, and those of the bodies
    forms: Array  # mass and damping matrices of the shaft (see `Structure`), shape (3 m, m)
    Minv: Array  # inverse of its mass matrix, shape (m, m)
    motion: Motion  # coefficients of the shaft's motion without contact
    spin: Sites  # record of type `bodies.SPIN`, in an array of length 1
    sites: Sites
    equations: Equations  # room for the contact equations, two for each site
    stages: Array  # states and derivatives of the integration, for `stages_of`
    n_translations: int  # of the degrees of freedom, the first ones, which are translations of planes
    faces: Array  # records and rows of the faces, for `faces_of`


@views
def stages_of(r: Array) -> Stages:
    """Return the rows of `Workspace.stages` by name."""
    return Stages(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8])


@views
def energy_integrals(z: Array, n: int) -> np.record:
    """Return the energy integrals in a state with n degrees of freedom, or in its derivative."""
    integrals: np.record = part(z, 2 * n, ENERGY_INTEGRALS, 1)[0]
    return integrals


@views
def site_integrals(z: Array, n: int, k: int) -> np.record:
    """Return the integrals of site k in a state or its derivative."""
    integrals: np.record = part(z, 2 * n + N_INTEGRALS + k * N_SITE_INTEGRALS, SITE_INTEGRALS, 1)[0]
    return integrals


@views
def face_integrals(z: Array, n: int, n_sites: int, k: int) -> np.record:
    """Return the integrals of face k in a state or its derivative."""
    at = 2 * n + N_INTEGRALS + n_sites * N_SITE_INTEGRALS + k * N_FACE_INTEGRALS
    integrals: np.record = part(z, at, FACE_INTEGRALS, 1)[0]
    return integrals


@views
def with_motion(w: Workspace, motion: Motion) -> Workspace:
    """Return the same workspace with another motion."""
    return Workspace(w.n, w.forms, w.Minv, motion, w.spin, w.sites, w.equations, w.stages, w.n_translations, w.faces)
