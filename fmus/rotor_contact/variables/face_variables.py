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
        parameter(f"{face}.enabled", "1", f"Whether the rotor can touch its seat {at}", 1.0, type="Boolean"),
        parameter(
            f"{face}.clearance",
            "m",
            f"Distance to the seat with the rotor in the middle {at}",
            of.clearance,
            minimum=1e-6,
            maximum=0.1,
        ),
        parameter(f"{face}.radius", "m", f"Mean radius of the ring {at}", of.radius, minimum=1e-4, maximum=10.0),
        parameter(
            f"{face}.stiffness",
            "N/m",
            f"Stiffness of ring and seat {at}, in the direction of the shaft",
            STIFFNESS,
            minimum=1e3,
            maximum=1e12,
        ),
        parameter(
            f"{face}.restitution",
            "1",
            f"Coefficient of restitution {at}, which sets the damping of ring and seat",
            RESTITUTION,
            minimum=0.05,
            maximum=1.0,
        ),
        parameter(
            f"{face}.on_mount",
            "1",
            f"Whether the seat {at} moves across the shaft with the housing of its retainer, and pushes it by friction",
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
            f"Remaining distance from the seat {at}, mean over the ring; negative under load",
            initially_depends_on=(f"{face}.clearance",),
            display_unit="um",
        ),
        output(f"{face}.mode", "1", f"Mode of contact {at}", initially_depends_on=(), **enumerated(CONTACT_MODE)),
        output(f"{face}.f_n", "N", f"Force of the seat on the rotor along the shaft {at}", initially_depends_on=()),
        output(
            f"{face}.f_n_peak",
            "N",
            f"Largest value of this force {at} during the last communication step",
            initially_depends_on=(),
            over_step="largest",
        ),
        output(
            f"{face}.f_n_mean",
            "N",
            f"Mean of this force {at} over the last communication step",
            initially_depends_on=(),
            over_step="mean",
        ),
        output(
            f"{face}.torque",
            "N.m",
            f"Mean torque of friction on the rotor {at} over the last communication step",
            initially_depends_on=(),
            over_step="mean",
        ),
        *(
            output(
                f"{face}.centre_{axis}",
                "m",
                f"Centre of pressure {at} in {axis}, from the middle of the ring",
                initially_depends_on=(),
            )
            for axis in "xy"
        ),
        output(f"{face}.heat", "J", f"Heat so far from friction and compression {at}", initially_depends_on=()),
    ]
