"""Variables of a face that limits the rotor's axial motion."""

from __future__ import annotations

from fmi_export.variables import Variable, enumerated, output, parameter
from rotor_contact.variables.enumerations import CONTACT_MODE
from rotor_contact.variables.planes import Face

STIFFNESS, RESTITUTION = 3e7, 0.3  # N/m and 1, assumed: hardly anybody has measured them


def face_parameters(of: Face) -> list[Variable]:
    """Return the parameters of a face."""
    face, at = of.name, f"at {of.name.upper()}"
    return [
        parameter(f"{face}.enabled", "1", f"Whether the rotor can touch the seat {at}", 1.0, type="Boolean"),
        parameter(
            f"{face}.clearance",
            "m",
            f"Distance to the seat {at} while the rotor is in the middle of its travel",
            of.clearance,
            minimum=1e-6,
            maximum=0.1,
        ),
        parameter(
            f"{face}.radius",
            "m",
            f"Mean radius of the ring that touches the seat {at}",
            of.radius,
            minimum=1e-4,
            maximum=10.0,
        ),
        parameter(
            f"{face}.stiffness",
            "N/m",
            f"Stiffness of the ring and the seat {at} in z",
            STIFFNESS,
            minimum=1e3,
            maximum=1e12,
        ),
        parameter(
            f"{face}.restitution",
            "1",
            f"Coefficient of restitution {at}, which determines the damping of the ring and the seat",
            RESTITUTION,
            minimum=0.05,
            maximum=1.0,
        ),
        parameter(
            f"{face}.on_mount",
            "1",
            f"Whether the seat {at} moves in x and y with the housing of its retainer, and pushes the housing by "
            f"friction",
            1.0,
            type="Boolean",
        ),
        parameter(f"{face}.mu", "1", f"Coefficient of friction {at}", 0.0, minimum=0.0, maximum=10.0),
        *(
            parameter(
                f"{face}.seat_tilt_{axis}",
                "rad",
                f"Slope d{axis}/dz of the axis of the seat {at}",
                0.0,
                minimum=-0.1,
                maximum=0.1,
            )
            for axis in "xy"
        ),
    ]


def face_outputs(face: str) -> list[Variable]:
    """Return the outputs of a face; the rotor starts in the middle, without contact."""
    at = f"at {face.upper()}"
    return [
        output(
            f"{face}.gap",
            "m",
            f"Mean distance of the ring from the seat {at}, which is negative under load",
            initially_depends_on=(f"{face}.clearance",),
            display_unit="um",
        ),
        output(f"{face}.mode", "1", f"Mode of contact {at}", initially_depends_on=(), **enumerated(CONTACT_MODE)),
        output(
            f"{face}.f_n", "N", f"Magnitude of the force of the seat {at} on the rotor in z", initially_depends_on=()
        ),
        output(
            f"{face}.f_n_peak",
            "N",
            f"Largest force of the seat {at} on the rotor during the last communication step",
            initially_depends_on=(),
            over_step="largest",
        ),
        output(
            f"{face}.f_n_mean",
            "N",
            f"Mean force of the seat {at} on the rotor over the last communication step",
            initially_depends_on=(),
            over_step="mean",
        ),
        output(
            f"{face}.torque",
            "N.m",
            f"Mean friction torque on the rotor {at} over the last communication step, positive in the direction of "
            f"positive spin",
            initially_depends_on=(),
            over_step="mean",
        ),
        *(
            output(
                f"{face}.centre_{axis}",
                "m",
                f"Distance in {axis} of the centre of pressure {at} from the middle of the ring",
                initially_depends_on=(),
            )
            for axis in "xy"
        ),
        output(f"{face}.heat", "J", f"Heat so far from friction and compression {at}", initially_depends_on=()),
    ]
