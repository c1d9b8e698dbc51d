"""Variables of the axes of magnetic bearings, and of the motion along the shaft of rotors with a thrust disc."""

from __future__ import annotations

from fmi_export.variables import Variable, at_place, input_, output, parameter
from rotor_contact.variables.start_values import ALWAYS_SAME


def axis_inputs(bearing: str, axis: str) -> list[Variable]:
    """Return a bearing's inputs along an axis: force, its gradient, and displacement at which the force applies."""
    _, declare, _ = at_place(f"{bearing}.{{}}", f"at {bearing.upper()} in {axis}")
    return [
        declare(f"f_{axis}", "N", "Force on the rotor {}", field="force"),
        declare(
            f"k_{axis}{axis}",
            "N/m",
            "Gradient of the force {} with respect to the displacement, positive if destabilising",
            field="gradient",
        ),
        declare(
            f"{axis}_ref", "m", "Displacement at which the force {} was evaluated", field="reference", display_unit="um"
        ),
    ]


def axial_parameters(thrust: str) -> list[Variable]:
    """Return the parameter of the motion along the shaft; `thrust` is the name of the disc."""
    tilt = (
        "Angle at which the shaft rises towards larger z, so that gravity acts along the shaft with its sine and "
        "across the shaft with its cosine"
    )
    return [parameter(f"{thrust}.tilt", "rad", tilt, 0.0)]


def axial_inputs(thrust: str) -> list[Variable]:
    """Return the inputs along the shaft: thrust magnet, any other force, and acceleration of the base."""
    return [
        *axis_inputs(thrust, "z"),
        input_(f"{thrust}.f_process", "N", "Other force on the rotor in z, such as the process force"),
        input_("base.a_z", "m/s2", "Acceleration of the base in z", field="base_acceleration"),
    ]


def axial_outputs(thrust: str) -> list[Variable]:
    """Return displacement and velocity along the shaft; the rotor starts at rest in the middle."""
    place = "Displacement of the rotor in z from the middle of its travel"
    return [
        output(f"{thrust}.z", "m", place, **ALWAYS_SAME, display_unit="um"),
        output(f"{thrust}.speed", "m/s", "Velocity of the rotor in z", **ALWAYS_SAME),
    ]
