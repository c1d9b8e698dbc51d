"""Variables of a face that limits the rotor's axial motion."""

from __future__ import annotations

from fmi_export.variables import Variable, at_place, enumerated
from rotor_contact.variables.enumerations import CONTACT_MODE
from rotor_contact.variables.planes import Face
from rotor_contact.variables.start_values import ALWAYS_SAME

STIFFNESS, RESTITUTION = 3e7, 0.3  # N/m and 1, assumed: hardly anybody has measured them


def face_parameters(of: Face) -> list[Variable]:
    """Return the parameters of a face."""
    declare, *_ = at_place(f"{of.name}.{{}}", f"at {of.name.upper()}")
    return [
        declare("enabled", "1", "Whether the rotor can touch the seat {}", 1.0, type="Boolean"),
        declare(
            "clearance",
            "m",
            "Distance to the seat {} while the rotor is in the middle of its travel",
            of.clearance,
            minimum=1e-6,
            maximum=0.1,
        ),
        declare(
            "radius", "m", "Mean radius of the ring that touches the seat {}", of.radius, minimum=1e-4, maximum=10.0
        ),
        declare("stiffness", "N/m", "Stiffness of the ring and the seat {} in z", STIFFNESS, minimum=1e3, maximum=1e12),
        declare(
            "restitution",
            "1",
            "Coefficient of restitution {}, which determines the damping of the ring and the seat",
            RESTITUTION,
            minimum=0.05,
            maximum=1.0,
        ),
        declare(
            "on_mount",
            "1",
            "Whether the seat {} moves in x and y with the housing of its retainer, and pushes the housing by friction",
            1.0,
            type="Boolean",
        ),
        declare("mu", "1", "Coefficient of friction {}", 0.0, minimum=0.0, maximum=10.0),
        *(
            declare(
                f"seat_tilt_{axis}",
                "rad",
                f"Slope d{axis}/dz of the axis of the seat {{}}",
                0.0,
                minimum=-0.1,
                maximum=0.1,
            )
            for axis in "xy"
        ),
    ]


def face_outputs(face: str) -> list[Variable]:
    """Return the outputs of a face; the rotor starts in the middle, without contact."""
    *_, declare = at_place(f"{face}.{{}}", f"at {face.upper()}")
    return [
        declare(
            "gap",
            "m",
            "Mean distance of the ring from the seat {}, which is negative under load",
            initially_depends_on=(f"{face}.clearance",),
            display_unit="um",
        ),
        declare("mode", "1", "Mode of contact {}", **ALWAYS_SAME, **enumerated(CONTACT_MODE)),
        declare("f_n", "N", "Magnitude of the force of the seat {} on the rotor in z", **ALWAYS_SAME),
        declare(
            "f_n_peak",
            "N",
            "Largest force of the seat {} on the rotor during the last communication step",
            over_step="largest",
            **ALWAYS_SAME,
        ),
        declare(
            "f_n_mean",
            "N",
            "Mean force of the seat {} on the rotor over the last communication step",
            over_step="mean",
            **ALWAYS_SAME,
        ),
        declare(
            "torque",
            "N.m",
            "Mean friction torque on the rotor {} over the last communication step, positive in the direction of "
            "positive spin",
            over_step="mean",
            **ALWAYS_SAME,
        ),
        *(
            declare(
                f"centre_{axis}",
                "m",
                f"Distance in {axis} of the centre of pressure {{}} from the middle of the ring",
                **ALWAYS_SAME,
            )
            for axis in "xy"
        ),
        declare("heat", "J", "Heat so far from friction and compression {}", **ALWAYS_SAME),
    ]
