"""Values of the plant's switches and states."""

from __future__ import annotations

from fmi_export.variables import Enumeration

IMPACT_LAW = Enumeration(
    "ImpactLaw",
    (
        ("nodal", "only the radial velocity of the touching node becomes zero (4.22, 4.23)"),
        ("newton", "momentum-consistent impact with restitution"),
    ),
)
NODAL, NEWTON = range(2)
CONTACT_MODE = Enumeration("ContactMode", (("free", ""), ("sliding", ""), ("rolling", "")))
FREE, SLIDING, ROLLING = range(3)
METHOD = Enumeration(  # how a step was computed
    "Method",
    (
        ("exact", "the whole step by matrices"),
        ("pieces", "halves, quarters, ... of the step by matrices"),
        ("events", "partly by substeps, where the motion is not smooth enough for a piece"),
        (
            "no_matrices",
            "by substeps, because there are no matrices: they need 32 equal steps (1 at the start), and neither the "
            "speed nor a mode may be too fast",
        ),
        ("compliant", "by substeps: a compliant contact law"),
        ("integrated", "by substeps: solver.exact_motion is false"),
    ),
)
EXACT, PIECES, EVENTS, NO_MATRICES, COMPLIANT, INTEGRATED = range(6)
