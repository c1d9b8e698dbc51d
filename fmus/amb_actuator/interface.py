"""Variable table of the actuator, which follows from its bearings."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from amb_actuator.flux import saturation_flux
from fmi_export.interface import Interface, interface, repeated
from fmi_export.variables import Enumeration, Variable, input_, one_of, output, parameter

FORCE_LAW = Enumeration(
    "ForceLaw",
    (
        ("linear", "constants from the geometry (2.8, 2.9)"),
        ("measured", "linear too, constants measured (Fig. 2.5)"),
        ("nonlinear", "square of current over gap (2.6), with saturation"),
    ),
)
LAWS = FORCE_LAW.names
LINEAR, MEASURED, NONLINEAR = range(len(LAWS))
AMPLIFIER = Enumeration(
    "Amplifier", (("ideal", "the currents are there at once"), ("dynamic", "bandwidth and voltage limit"))
)
IDEAL, DYNAMIC = range(2)

# K_s (N/m) and K_i (N/A) of force_law 1: measured on the rig (Fig. 2.5); elsewhere those of the geometry, (2.8, 2.9).
MEASURED_CONSTANTS = {"mb1": (1.944e6, 544.0), "mb2": (2.156e6, 539.0)}
CONSTANTS_FROM_GEOMETRY = (2376955.7160887653, 563.1506658084571)

# Table 2.2.
POLE_FACE, HALF_POLE_ANGLE, MAX_FORCE = 1399e-6, math.radians(22.5), 1700.0


def _magnet(b: str, a: str, at: str) -> list[Variable]:
    k_s, k_i = MEASURED_CONSTANTS.get(b, CONSTANTS_FROM_GEOMETRY)
    return [
        parameter(f"{b}.turns_{a}", "1", f"Turns per pole, {at} (Table 2.2)", 158.0, minimum=1.0, maximum=1e6),
        parameter(
            f"{b}.pole_area_{a}", "m2", f"Pole face area, {at} (Table 2.2)", POLE_FACE, minimum=1e-9, maximum=10.0
        ),
        parameter(f"{b}.gap_{a}", "m", f"Air gap, {at} (Table 2.2)", 1.2e-3, minimum=1e-6, maximum=1.0),
        parameter(
            f"{b}.half_angle_{a}",
            "rad",
            f"Half angle between the double pole faces, {at} (2.2)",
            HALF_POLE_ANGLE,
            minimum=0.0,
            maximum=1.5,
        ),
        parameter(f"{b}.bias_current_{a}", "A", f"Bias current, {at} (Table 2.2)", 4.43, minimum=0.0, maximum=1e4),
        parameter(
            f"{b}.static_current_{a}",
            "A",
            f"Static current; negative for a static load towards positive displacements, {at} (Table 2.2)",
            1.14,
            minimum=-1e4,
            maximum=1e4,
        ),
        parameter(
            f"{b}.current_limit_{a}", "A", f"Largest coil current, {at} (Table 2.4)", 10.0, minimum=0.0, maximum=1e4
        ),
        parameter(
            f"{b}.k_s_measured_{a}",
            "N/m",
            f"Negative stiffness for force_law 1, {at} (Fig. 2.5)",
            k_s,
            minimum=-1e12,
            maximum=1e12,
        ),
        parameter(
            f"{b}.k_i_measured_{a}",
            "N/A",
            f"Current stiffness for force_law 1, {at} (Fig. 2.5)",
            k_i,
            minimum=-1e9,
            maximum=1e9,
        ),
        parameter(
            f"{b}.b_sat_{a}",
            "T",
            f"Saturation flux density for force_law 2, {at}; by default a coil pair pulls at most 1700 N (Table 2.2)",
            saturation_flux(MAX_FORCE, POLE_FACE, HALF_POLE_ANGLE),
            minimum=1e-3,
            maximum=1e3,
        ),
        parameter(
            f"{b}.knee_width_{a}",
            "1",
            f"Half-width of the knee of saturation, relative to b_sat, {at}",
            0.2,
            minimum=0.0,
            maximum=1.0,
        ),
    ]


def _amplifier(b: str, a: str, at: str) -> list[Variable]:
    return [
        parameter(
            f"{b}.resistance_{a}",
            "Ohm",
            f"Resistance of a coil pair, {at} (Table 2.2)",
            0.365,
            minimum=1e-3,
            maximum=1e6,
        ),
        parameter(
            f"{b}.inductance_{a}",
            "H",
            f"Inductance of a coil pair, {at} (Table 2.2)",
            0.0732,
            minimum=1e-9,
            maximum=1e3,
        ),
        parameter(
            f"{b}.amplifier_gain_{a}",
            "A/V",
            f"Control current demanded by a volt of command, {at} (Table 2.4)",
            0.5,
            minimum=-1e6,
            maximum=1e6,
        ),
        parameter(
            f"{b}.bandwidth_{a}",
            "Hz",
            f"Bandwidth of the dynamic amplifier, {at} (Table 2.4)",
            1400.0,
            minimum=1e-3,
            maximum=1e9,
        ),
        parameter(
            f"{b}.voltage_limit_{a}",
            "V",
            f"Largest voltage of the dynamic amplifier, either way, {at} (assumed)",
            150.0,
            minimum=1e-3,
            maximum=1e9,
        ),
        parameter(
            f"{b}.discharge_voltage_{a}",
            "V",
            f"Voltage that brings the currents down while the amplifiers are off; 0: the coils' resistance alone, {at}",
            0.0,
            minimum=0.0,
            maximum=1e9,
        ),
    ]


def _inputs(b: str, a: str, at: str) -> list[Variable]:
    return [
        input_(f"{b}.i_{a}", "A", f"Demanded control current, {at}", field="demanded_current"),
        input_(f"{b}.{a}", "m", f"Rotor displacement from the centre, {at}", field="displacement", display_unit="um"),
        input_(
            f"{b}.command_voltage_{a}",
            "V",
            f"Command as a voltage; amplifier_gain times it adds to the demanded control current, {at}",
        ),
        input_(
            f"{b}.coil_loss_upper_{a}",
            "1",
            f"Fault: share of the upper coil pair's turns that is lost, {at}",
            minimum=0.0,
            maximum=1.0,
        ),
        input_(
            f"{b}.coil_loss_lower_{a}",
            "1",
            f"Fault: share of the lower coil pair's turns that is lost, {at}",
            minimum=0.0,
            maximum=1.0,
        ),
        input_(
            f"{b}.amplifier_off_{a}",
            "1",
            f"Fault: amplifiers off, currents decay through the coils, {at}",
            type="Boolean",
        ),
        input_(f"{b}.stuck_{a}", "1", f"Fault: currents stay as they are, {at}", type="Boolean"),
    ]


def _outputs(b: str, a: str, at: str) -> list[Variable]:
    def of_axis(*names: str) -> tuple[str, ...]:
        return tuple(f"{b}.{name}_{a}" for name in names)

    demand = of_axis("i", "command_voltage")
    off, switches = of_axis("amplifier_off"), of_axis("amplifier_off", "stuck")
    losses = of_axis("coil_loss_upper", "coil_loss_lower")
    current = (*demand, *switches)
    force = (*demand, f"{b}.{a}", *losses, *switches)
    # At the start the currents are those of a steady command; nothing is stuck, and no voltage at its limit.
    limits = of_axis("bias_current", "static_current", "current_limit", "resistance", "voltage_limit")
    command = (*demand, *of_axis("amplifier_gain"), *limits, "amplifier")
    currents = (*command, *off)
    iron = (*currents, *of_axis("turns", "gap", "b_sat", "knee_width"), f"{b}.{a}", *losses)
    gradient = (*iron, *of_axis("pole_area", "half_angle", "k_s_measured"), "force_law")
    flag: dict[str, object] = {"type": "Boolean"}
    return [
        output(
            f"{b}.f_{a}",
            "N",
            f"Force on the rotor, in excess of the static load unless total_force, {at}",
            depends_on=force,
            starts_from=(*gradient, *of_axis("k_i_measured"), "total_force"),
            field="force",
        ),
        output(
            f"{b}.k_{a}{a}",
            "N/m",
            f"Gradient of the force over displacement, {at}",
            depends_on=force,
            starts_from=gradient,
            field="gradient",
        ),
        output(
            f"{b}.{a}_ref",
            "m",
            f"Displacement where the force was evaluated, {at}",
            depends_on=(f"{b}.{a}",),
            starts_as=f"{b}.{a}",
            display_unit="um",
            field="reference",
        ),
        output(
            f"{b}.i_upper_{a}",
            "A",
            f"Current of the upper coil pair, {at}",
            depends_on=current,
            starts_from=currents,
            field="upper_current",
        ),
        output(
            f"{b}.i_lower_{a}",
            "A",
            f"Current of the lower coil pair, {at}",
            depends_on=current,
            starts_from=currents,
            field="lower_current",
        ),
        output(
            f"{b}.clipped_{a}",
            "1",
            f"The demanded current was cut to the coil limits, {at}",
            depends_on=demand,
            starts_from=command,
            warning=f"the demanded current is cut to what the coils allow, 0 to {{{b}.current_limit_{a}}} A each",
            **flag,
        ),
        output(
            f"{b}.saturated_{a}",
            "1",
            f"The flux density of a coil pair is beyond the knee, where force_law 2 limits it, {at}",
            depends_on=force,
            starts_from=iron,
            warning=f"a coil pair saturates at {{{b}.b_sat_{a}}} T, which force_law 2 alone knows of",
            **flag,
        ),
        output(
            f"{b}.voltage_limited_{a}",
            "1",
            f"An amplifier was at its voltage limit during the step, {at}",
            depends_on=current,
            starts_from=(),
            warning=f"an amplifier is at its voltage limit, {{{b}.voltage_limit_{a}}} V",
            **flag,
        ),
        output(
            f"{b}.v_upper_{a}",
            "V",
            f"Voltage at the upper coil pair, {at}",
            depends_on=current,
            starts_from=currents,
            field="upper_voltage",
        ),
        output(
            f"{b}.v_lower_{a}",
            "V",
            f"Voltage at the lower coil pair, {at}",
            depends_on=current,
            starts_from=currents,
            field="lower_voltage",
        ),
        output(
            f"{b}.copper_loss_{a}",
            "W",
            f"Heat in both coil pairs, {at}",
            minimum=0.0,
            depends_on=current,
            starts_from=currents,
        ),
    ]


def _axis(bearing: str, axis: str) -> list[Variable]:
    """Declare the variables of one axis."""
    at = f"{bearing.upper()}, {axis} axis"
    declared = [v for table in (_magnet, _amplifier, _inputs, _outputs) for v in table(bearing, axis, at)]
    return [replace(v, field=v.field or v.name.removeprefix(f"{bearing}.").removesuffix(f"_{axis}")) for v in declared]


def axes_of(bearings: Sequence[str]) -> list[tuple[str, str]]:
    """Return the axes of bearings in the order of their variables: x and y of each in turn."""
    return [(bearing, axis) for bearing in bearings for axis in "xy"]


def interface_of(bearings: Sequence[str]) -> Interface:
    """Return the variables of an actuator of these bearings."""
    return interface(
        *_MODEL_PARAMETERS,
        repeated("axes", axes_of(bearings), _axis),
        output("fault_code", "1", "0 while all is well; the log says what else means", type="Integer", starts_from=()),
    )


_MODEL_PARAMETERS = (
    parameter("force_law", "1", "How force follows from displacement and currents", LINEAR, **one_of(FORCE_LAW)),
    parameter("amplifier", "1", "How the currents follow what is demanded", IDEAL, **one_of(AMPLIFIER)),
    parameter(
        "total_force",
        "1",
        "Forces include the pull of the static currents, which a plant with gravity needs; "
        "otherwise they are in excess of the static load",
        0.0,
        type="Boolean",
    ),
    parameter(
        "mean_current",
        "1",
        "Force of the mean currents over a step in place of those at its end: "
        "for a master that moves the rotor over the same step afterwards",
        0.0,
        type="Boolean",
    ),
)

# One bearing, for the record types of its axes.
SMALLEST = interface_of(("b",)).with_all_parts()
