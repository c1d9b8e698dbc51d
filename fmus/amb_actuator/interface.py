"""Variable table of the actuator, derived from its bearings."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from amb_actuator.flux import saturation_flux
from fmi_export.interface import Interface, interface, repeated
from fmi_export.variables import FAULT, Enumeration, Variable, at_place, enumerated, parameter

Declare = Callable[..., Variable]
"""Declares a variable of an axis; see `at_place`."""

FORCE_LAW = Enumeration(
    "ForceLaw",
    (
        ("linear", "a linear law with constants from the geometry"),
        ("measured", "a linear law with the constants k_s_measured and k_i_measured"),
        ("nonlinear", "the square of current over gap, with saturation"),
    ),
)
LAWS = FORCE_LAW.names
LINEAR, MEASURED, NONLINEAR = range(len(LAWS))
AMPLIFIER = Enumeration(
    "Amplifier",
    (
        ("ideal", "the currents equal the demand at once"),
        ("dynamic", "the currents follow the demand with a limited bandwidth and voltage"),
    ),
)
IDEAL, DYNAMIC = range(2)

# K_s (N/m) and K_i (N/A) of force_law 1: measured on the rig (Fig. 2.5); elsewhere those of the geometry, (2.8, 2.9).
MEASURED_CONSTANTS = {"mb1": (1.944e6, 544.0), "mb2": (2.156e6, 539.0)}
CONSTANTS_FROM_GEOMETRY = (2376955.7160887653, 563.1506658084571)

# Start values are those of the rig: magnets of Table 2.2, with a pull of at most 1700 N, and amplifiers of Table 2.4,
# whose voltage limit is assumed.
POLE_FACE, HALF_POLE_ANGLE, MAX_FORCE = 1399e-6, math.radians(22.5), 1700.0


def _axis(bearing: str, axis: str) -> list[Variable]:
    """Declare the variables of an axis; axis z of a thrust magnet is perpendicular to the pole faces."""
    parameter_of, input_of, output_of = at_place(f"{bearing}.{{}}_{axis}", f"at {bearing.upper()} in {axis}")
    return [
        *_magnet(
            parameter_of,
            *MEASURED_CONSTANTS.get(bearing, CONSTANTS_FROM_GEOMETRY),
            *((0.0, 0.0) if axis == "z" else (HALF_POLE_ANGLE, 1.14)),
        ),
        *_amplifier(parameter_of),
        *_inputs(input_of, f"{bearing}.{axis}"),
        *_outputs(output_of, bearing, axis),
    ]


def _magnet(declare: Declare, k_s: float, k_i: float, half_angle: float, static: float) -> list[Variable]:
    b_sat = saturation_flux(MAX_FORCE, POLE_FACE, HALF_POLE_ANGLE)
    return [
        declare(
            "turns",
            "1",
            "Number of turns per pole {}, or half the turns of a coil around the shaft",
            158.0,
            minimum=1.0,
            maximum=1e6,
        ),
        declare("pole_area", "m2", "Area of a pole face {}", POLE_FACE, minimum=1e-9, maximum=10.0),
        declare("gap", "m", "Air gap {}", 1.2e-3, minimum=1e-6, maximum=1.0),
        declare(
            "half_angle",
            "rad",
            "Half the angle between the two pole faces of a coil pair {}",
            half_angle,
            minimum=0.0,
            maximum=1.5,
        ),
        declare("bias_current", "A", "Bias current of both coil pairs {}", 4.43, minimum=0.0, maximum=1e4),
        declare(
            "static_current",
            "A",
            "Current that the upper coil pair {} carries in addition to the bias, negative for a static load towards "
            "positive displacements",
            static,
            minimum=-1e4,
            maximum=1e4,
        ),
        declare("current_limit", "A", "Largest magnitude of the current of a coil {}", 10.0, minimum=0.0, maximum=1e4),
        declare(
            "permanent_bias",
            "A",
            "Part of bias_current {} that permanent magnets replace, so that no coil carries it and it remains without "
            "power",
            0.0,
            minimum=0.0,
            maximum=1e4,
        ),
        declare(
            "k_s_measured",
            "N/m",
            "Negative stiffness {} for force_law 1, positive if destabilising",
            k_s,
            minimum=-1e12,
            maximum=1e12,
        ),
        declare("k_i_measured", "N/A", "Current stiffness {} for force_law 1", k_i, minimum=-1e9, maximum=1e9),
        declare(
            "b_sat",
            "T",
            "Flux density at which the iron {} saturates",
            b_sat,
            minimum=1e-3,
            maximum=1e3,
        ),
        declare(
            "knee_width",
            "1",
            "Half the width of the knee of saturation {}, relative to b_sat",
            0.2,
            minimum=0.0,
            maximum=1.0,
        ),
    ]


def _iron(thrust: str) -> list[Variable]:
    """Declare the parameters of the solid iron of a thrust magnet."""
    return [
        parameter(
            f"{thrust}.eddy_current_corner",
            "Hz",
            f"Frequency at which eddy currents in the solid iron at {thrust.upper()} in z add as much reluctance as "
            f"the air gap has, or 0 without eddy currents",
            0.0,
            minimum=0.0,
            maximum=1e9,
        )
    ]


def _amplifier(declare: Declare) -> list[Variable]:
    return [
        declare("resistance", "Ohm", "Resistance of a coil pair {}", 0.365, minimum=1e-3, maximum=1e6),
        declare("inductance", "H", "Inductance of a coil pair {}", 0.0732, minimum=1e-9, maximum=1e3),
        declare(
            "amplifier_gain",
            "A/V",
            "Control current per volt of command_voltage {}",
            0.5,
            minimum=-1e6,
            maximum=1e6,
        ),
        declare("bandwidth", "Hz", "Bandwidth of the dynamic amplifiers {}", 1400.0, minimum=1e-3, maximum=1e9),
        declare(
            "voltage_limit",
            "V",
            "Largest magnitude of the voltage of the dynamic amplifiers {}",
            150.0,
            minimum=1e-3,
            maximum=1e9,
        ),
        declare(
            "discharge_voltage",
            "V",
            "Voltage against which the coils {} discharge while the amplifiers are off, or 0 if only their resistance "
            "reduces the currents",
            0.0,
            minimum=0.0,
            maximum=1e9,
        ),
    ]


def _inputs(declare: Declare, displacement: str) -> list[Variable]:
    at_centre = declare("", "m", "Displacement of the rotor {}", field="displacement", display_unit="um")
    command = "Command voltage {}, which is multiplied by amplifier_gain and added to the demanded control current"
    lost = "Fault: fraction of its turns that the {} coil pair {{}} has lost"
    off = "Fault: the amplifiers {} are off, and the currents decay"
    return [
        declare(
            "i",
            "A",
            "Demanded control current {}, positive for a force towards positive displacements",
            field="demanded_current",
        ),
        replace(at_centre, name=displacement),
        declare("command_voltage", "V", command),
        *(declare(f"coil_loss_{c}", "1", lost.format(c), minimum=0.0, maximum=1.0) for c in ("upper", "lower")),
        declare("amplifier_off", "1", off, type="Boolean"),
        declare("stuck", "1", "Fault: the currents {} keep their values", type="Boolean"),
    ]


def _outputs(declare: Declare, b: str, a: str) -> list[Variable]:
    def of_axis(*names: str) -> tuple[str, ...]:
        return tuple(f"{b}.{name}_{a}" for name in names)

    demand = of_axis("i", "command_voltage")
    off, switches = of_axis("amplifier_off"), of_axis("amplifier_off", "stuck")
    losses = of_axis("coil_loss_upper", "coil_loss_lower")
    current = (*demand, *losses, *switches)
    # At the start the currents are those of a steady command; nothing is stuck, and no voltage at its limit.
    limits = of_axis("bias_current", "static_current", "current_limit", "permanent_bias", "resistance", "voltage_limit")
    command = (*demand, *of_axis("amplifier_gain"), *limits, "amplifier")
    currents = (*command, *off, *losses)
    iron = (*currents, *of_axis("turns", "gap", "b_sat", "knee_width"), f"{b}.{a}")
    gradient = (*iron, *of_axis("pole_area", "half_angle", "k_s_measured"), "force_law")
    by_force: dict[str, object] = {"depends_on": (*current, f"{b}.{a}")}
    by_current: dict[str, tuple[str, ...]] = {"depends_on": current, "initially_depends_on": currents}

    def named(name: str, unit: str, description: str, **options: object) -> Variable:
        return replace(declare("", unit, description, **options), name=f"{b}.{name}")

    def of_coils(letter: str, unit: str, description: str, field: str) -> list[Variable]:
        others = {"upper": losses[1], "lower": losses[0]}
        common = {
            coil: {key: tuple(name for name in names if name != other) for key, names in by_current.items()}
            for coil, other in others.items()
        }
        return [
            declare(f"{letter}_{coil}", unit, description.format(coil), field=f"{coil}_{field}", **common[coil])
            for coil in others
        ]

    def flag(name: str, description: str, warning: str, **options: object) -> Variable:
        return declare(name, "1", description, type="Boolean", warning=warning, **options)

    force = "Force on the rotor {}, in excess of the static load unless total_force is true"
    reference = "Displacement at which the force {} was evaluated"
    clipped = (
        f"the demanded current is limited to what the coils can carry, at most {{{b}.current_limit_{a}}} A "
        "each without a reversal of the flux"
    )
    saturated = (
        "Whether the flux density of a coil pair {} is beyond the knee of saturation, which only force_law 2 models"
    )
    beyond = (
        f"a coil pair saturates at {{{b}.b_sat_{a}}} T, which only force_law 2 (nonlinear) models, so that the other "
        f"laws overestimate the force"
    )
    at_limit = f"an amplifier is at its voltage limit, {{{b}.voltage_limit_{a}}} V"
    return [
        declare(
            "f",
            "N",
            force,
            initially_depends_on=(*gradient, *of_axis("k_i_measured"), "total_force"),
            field="force",
            **by_force,
        ),
        named(
            f"k_{a}{a}",
            "N/m",
            "Gradient of the force {} with respect to the displacement, positive if destabilising"
            + (", or 0 with eddy currents" if a == "z" else ""),
            initially_depends_on=(*gradient, *((f"{b}.eddy_current_corner",) if a == "z" else ())),
            field="gradient",
            **by_force,
        ),
        named(
            f"{a}_ref",
            "m",
            reference,
            depends_on=(f"{b}.{a}",),
            initially_equals=f"{b}.{a}",
            display_unit="um",
            field="reference",
        ),
        *of_coils("i", "A", "Current of the {} coil pair {{}}", "current"),
        flag(
            "clipped",
            "Whether the demanded current {} was limited to what the coils can carry",
            clipped,
            depends_on=(*demand, *off),
            initially_depends_on=(*command, *off),
        ),
        flag("saturated", saturated, beyond, initially_depends_on=iron, **by_force),
        flag(
            "voltage_limited",
            "Whether an amplifier {} was at its voltage limit during the last communication step",
            at_limit,
            **(by_current | {"initially_depends_on": ()}),
        ),
        *of_coils("v", "V", "Voltage of the {} coil pair {{}}", "voltage"),
        declare("copper_loss", "W", "Copper loss of both coil pairs {}", minimum=0.0, **by_current),
    ]


def axes_of(bearings: Sequence[str], thrust: str = "") -> list[tuple[str, str]]:
    """Return the axes in the order of their variables: x and y for each bearing, then z if there is a thrust magnet."""
    return [*((bearing, axis) for bearing in bearings for axis in "xy"), *([(thrust, "z")] if thrust else [])]


def interface_of(bearings: Sequence[str], thrust: str = "") -> Interface:
    """Return the variables of an actuator with these bearings and, if `thrust` is given, a thrust magnet."""
    return interface(
        *_MODEL_PARAMETERS,
        repeated("axes", axes_of(bearings, thrust), _axis),
        repeated("iron", [(thrust,)] if thrust else [], _iron),
        FAULT,
    )


_MODEL_PARAMETERS = (
    parameter(
        "force_law", "1", "Law of the force as a function of displacement and currents", LINEAR, **enumerated(FORCE_LAW)
    ),
    parameter("amplifier", "1", "Response of the currents to the demanded current", IDEAL, **enumerated(AMPLIFIER)),
    parameter(
        "total_force",
        "1",
        "Whether forces include the pull of the static currents, which a plant with gravity requires, instead of being "
        "in excess of the static load",
        0.0,
        type="Boolean",
    ),
    parameter(
        "mean_current",
        "1",
        "Whether forces follow from the mean currents over a step instead of the final ones, for masters that move the "
        "rotor over the same step afterwards",
        0.0,
        type="Boolean",
    ),
)

# A single bearing and a thrust magnet, for the record types of their axes.
SMALLEST = interface_of(("b",), "t").with_all_parts()
