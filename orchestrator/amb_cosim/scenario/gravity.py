"""Gravity in a scenario: on the rotor, and in the static currents of the magnetic bearings, which carry the weight."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

from amb_cosim.cosim.system.assignments import Assignments
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT

OF_MAGNET = (("gap", "m"), ("turns", ""), ("pole_area", "m2"), ("bias_current", "A"), ("current_limit", "A"))


@dataclass(frozen=True)
class Gravity:
    """Size of gravity, and the direction in which it pulls, from x towards y."""

    size: Raw
    angle: Raw


def set_gravity(values: Assignments, gravity: Gravity, rotor: str | None, given: Collection[str]) -> None:
    """Let gravity pull on the rotor, and its magnetic bearings, if there are any, carry the weight at their centres.

    The forces of the bearings become total forces, each axis gets the static current that carries its share of the
    weight, and the controller K_s, K_i and the least current of that operating point. A bearing that replaces the
    magnetic ones and has no `total_force` carries its share in its own way.

    Parameters
    ----------
    values
        The values of all parameters; changed.
    rotor
        Name or file of the rotor, the packs' default without.
    given
        Parameters, `component.variable`, that keep their values.

    Raises
    ------
    ValueError
        If a bearing cannot carry its share, or the bearings do not hold the rotor.
    """
    missing = _MissingParameters(values, given)
    missing.set(f"{PLANT}.gravity", gravity.size)
    missing.set(f"{PLANT}.gravity_angle", gravity.angle)
    if ACTUATOR in values.interfaces:
        missing.set(f"{ACTUATOR}.total_force", True)
        if not {f"{PLANT}.gravity", f"{ACTUATOR}.total_force"} & {*values.dropped}:
            _carry_weight(missing, rotor)


@dataclass(frozen=True)
class _MissingParameters:
    """Parameters that nobody gave."""

    values: Assignments
    given: Collection[str]

    def set(self, name: str, value: Raw) -> None:
        """Set a parameter, unless it was given."""
        if name not in self.given:
            self.values.set_or_drop(name, value, only="parameter")


def _carry_weight(missing: _MissingParameters, rotor: str | None) -> None:
    from rotor_analysis.rotor_file import load_rotor  # a scenario without gravity needs nothing of it
    from rotor_analysis.static_load import carried_masses

    size, angle = (missing.values.parameter(f"{PLANT}.{name}") for name in ("gravity", "gravity_angle"))
    for bearing, mass in carried_masses(load_rotor(rotor)).items():
        for axis, upwards in (("x", -math.cos(angle)), ("y", -math.sin(angle))):
            _carry(missing, bearing, axis, mass * size * upwards)


def _carry(missing: _MissingParameters, bearing: str, axis: str, load: float) -> None:
    """Set the static current of an axis that carries a load (N), and what the controller knows of it."""
    from amb_cosim.design.magnetic_bearing import axis_parameters, operating_constants, static_current_for

    values, static = missing.values, f"{ACTUATOR}.{bearing}.static_current_{axis}"
    law = int(values.parameter(f"{ACTUATOR}.force_law"))
    if static not in missing.given:
        without = {**_parameters_of(values, bearing, axis), "static_current": 0.0}
        try:
            missing.set(static, static_current_for(load, axis_parameters(bearing, axis, **without), law))
        except ValueError as error:
            magnet = ", ".join(f"{name}_{axis} = {without[name]:g} {unit}".rstrip() for name, unit in OF_MAGNET)
            raise ValueError(
                f"gravity: {bearing}.{axis} cannot carry its share of the weight: {error}; {bearing} has {magnet}"
            ) from error
    if CONTROLLER in values.interfaces:
        p = axis_parameters(bearing, axis, **_parameters_of(values, bearing, axis))
        k_s, k_i = operating_constants(p, law)
        for name, value in (("k_s", k_s), ("k_i", k_i), ("i_min", -float(p.static_current + p.bias_current))):
            missing.set(f"{CONTROLLER}.{bearing}.{name}_{axis}", value)


def _parameters_of(values: Assignments, bearing: str, axis: str) -> dict[str, float]:
    """Return the parameters of an axis of the actuator by their names without bearing and axis."""
    begin, end = f"{bearing}.", f"_{axis}"
    names = (p.name for p in values.interfaces[ACTUATOR].of("parameter"))
    of_axis = [name for name in names if name.startswith(begin) and name.endswith(end)]
    return {name.removeprefix(begin).removesuffix(end): values.parameter(f"{ACTUATOR}.{name}") for name in of_axis}
