"""Values of the plant's switches and states."""

from __future__ import annotations

from fmi_export.variables import Enumeration

IMPACT_LAW = Enumeration(
    "ImpactLaw",
    (
        ("nodal", "only the radial velocity of the touching node becomes zero"),
        ("newton", "momentum is conserved, and the rotor rebounds with the coefficient of restitution of the site"),
    ),
)
NODAL, NEWTON = range(2)
CONTACT_MODE = Enumeration("ContactMode", (("free", ""), ("sliding", ""), ("rolling", "")))
FREE, SLIDING, ROLLING = range(3)
METHOD = Enumeration(  # how a step was computed
    "Method",
    (
        ("exact", "matrices of the exact motion, for the whole step"),
        ("pieces", "matrices of the exact motion, for halves, quarters or smaller pieces of the step"),
        ("events", "matrices for some pieces of the step, and substeps where the motion is not smooth enough for them"),
        (
            "no_matrices",
            "substeps, because an input of the matrices, such as the step size, changed within the last 32 steps, or "
            "because the speed or a mode is too fast for matrices",
        ),
        ("compliant", "substeps, because a site has a compliant contact law"),
        ("integrated", "substeps, because solver.exact_motion is false"),
    ),
)
EXACT, PIECES, EVENTS, NO_MATRICES, COMPLIANT, INTEGRATED = range(6)
