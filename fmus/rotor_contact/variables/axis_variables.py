"""Variables of the axes of magnetic bearings, and of the motion along the shaft of rotors with a thrust disc."""

from __future__ import annotations

from fmi_export.variables import Variable, input_, output, parameter


def axis_inputs(bearing: str, axis: str) -> list[Variable]:
    """Return a bearing's inputs along an axis: force, its gradient, and displacement at which the force applies."""
    at = f"{bearing.upper()}, {axis} axis"
    return [
        input_(f"{bearing}.f_{axis}", "N", f"Force on the rotor, {at}", field="force"),
        input_(
            f"{bearing}.k_{axis}{axis}",
            "N/m",
            f"Gradient of that force with respect to displacement, {at}",
            field="gradient",
        ),
        input_(
            f"{bearing}.{axis}_ref",
            "m",
            f"Displacement at which that force applies, {at}",
            field="reference",
            display_unit="um",
        ),
    ]


def axial_parameters(thrust: str) -> list[Variable]:
    """Return the parameter of the motion along the shaft; `thrust` is the name of the disc."""
    return [
        parameter(
            f"{thrust}.tilt",
            "rad",
            "Angle of the shaft above the horizontal, positive with the end of larger z up; gravity acts along the "
            "shaft with its sine and across it with its cosine",
            0.0,
        )
    ]


def axial_inputs(thrust: str) -> list[Variable]:
    """Return the inputs along the shaft: thrust magnet, any other force, and acceleration of the base."""
    return [
        *axis_inputs(thrust, "z"),
        input_(f"{thrust}.f_process", "N", "Other force on the rotor along the shaft, such as the process force"),
        input_("base.a_z", "m/s2", "Acceleration of the base along the shaft", field="base_acceleration"),
    ]


def axial_outputs(thrust: str) -> list[Variable]:
    """Return displacement and velocity along the shaft; the rotor starts at rest in the middle."""
    return [
        output(
            f"{thrust}.z",
            "m",
            "Displacement of the rotor along the shaft",
            initially_depends_on=(),
            display_unit="um",
        ),
        output(f"{thrust}.speed", "m/s", "Velocity of the rotor along the shaft", initially_depends_on=()),
    ]
