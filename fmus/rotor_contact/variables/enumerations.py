"""Values of the plant's switches and states."""

from __future__ import annotations

from fmi_export.variables import Enumeration

IMPACT_LAW = Enumeration(
    "ImpactLaw",
    (
        ("nodal", "the radial velocity of the touching node alone becomes zero (4.22, 4.23)"),
        ("newton", "momentum-consistent impact with restitution"),
    ),
)
NODAL, NEWTON = range(2)
CONTACT_MODE = Enumeration("ContactMode", (("free", ""), ("sliding", ""), ("rolling", "")))
FREE, SLIDING, ROLLING = range(3)
CONTACT_LAW = Enumeration(  # the constraint, and the classical laws of 4.2 in the order of the thesis
    "ContactLaw",
    (
        ("constraint", "rigid"),
        ("linear", "spring"),
        ("hertz", "power 3/2 of the penetration"),
        ("kelvin_voigt", "spring and damper"),
        ("kirk", "spring and damper that engage with the penetration"),
        ("hunt_crossley", "Hertz with damping"),
        ("ulbrich", "Hertz with loss"),
        ("switched_kelvin_voigt", "spring and damper without pull"),
    ),
)
LAWS = CONTACT_LAW.names
CONSTRAINT, LINEAR, HERTZ, KELVIN_VOIGT, KIRK, HUNT_CROSSLEY, ULBRICH, SWITCHED_KELVIN_VOIGT = range(len(LAWS))
METHOD = Enumeration(  # how a step was computed
    "Method",
    (
        ("exact", "the whole step by its matrices"),
        ("pieces", "halves, quarters, ... by their matrices"),
        ("events", "partly by substeps, where no piece is smooth"),
        (
            "no_matrices",
            "by substeps: fewer than 32 identical steps so far (one at the start), or speed or modes too fast for "
            "matrices",
        ),
        ("compliant", "by substeps: a compliant contact law"),
        ("integrated", "by substeps: solver.exact_motion is false"),
    ),
)
EXACT, PIECES, EVENTS, NO_MATRICES, COMPLIANT, INTEGRATED = range(6)
