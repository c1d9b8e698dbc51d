"""Gravity in a scenario: it acts on the rotor, whose weight the static currents of the magnetic bearings carry.

A passive bearing or seal carries the share of the weight that its stiffness determines, with the rotor at the centres
of the magnets and at the first speed of the run.

On each axis, the coil pair that carries no weight has the bias current I_b. The other pair has the static current I_s
in addition:

    weight towards -x:  I_upper = I_b + I_s,  I_lower = I_b
    weight towards +x:  I_upper = I_b,        I_lower = I_b + I_s                                 (1)

A machine turned by 180 degrees therefore has the same magnets. In the second case the actuator's parameters are a bias
current I_b + I_s and a static current -I_s. If the shaft is tilted, the magnets of its thrust disc carry the axial
component of the weight, and the bearings carry the rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_cosim.cosim.system.values import quantity
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.operating_point import (
    GEOMETRY,
    MissingParameters,
    is_measured,
    magnet_axes,
    parameters_of,
    stated_constants,
)
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import SPEED, Scenario, share_across, tilt_of
from array_types import Array

if TYPE_CHECKING:
    from rotor_analysis.rotor import Rotor

STANDARD_GRAVITY = 9.81  # m/s^2
OF_MAGNET = (("gap", "m"), ("turns", ""), ("pole_area", "m2"), ("bias_current", "A"), ("current_limit", "A"))


def set_gravity(missing: MissingParameters, scenario: Scenario) -> list[str]:
    """Apply the gravity of a scenario, if any; magnetic bearings, if any, then carry the weight of the centred rotor.

    The forces of the bearings become total forces, and each axis gets the static current that carries its share of the
    weight. An FMU that replaces the bearings and has no `total_force` must carry the weight itself. Without gravity
    nothing is set; the returned warnings then name static currents that keep the model's start values although other
    data of the magnets are set.

    Parameters
    ----------
    missing
        The values of all parameters, and the names of those that are set or fixed.
    scenario
        Provides gravity and its direction (from x towards y), the tilt of the shaft, and the rotor.

    Raises
    ------
    ValueError
        If a bearing cannot carry its share, or the bearings do not hold the rotor.
    """
    if scenario.gravity is None:
        return _assumed_loads(missing)
    values = missing.values
    gravity, tilt = quantity(scenario.gravity, "m/s2", "gravity"), tilt_of(scenario.tilt)
    if thrust := _thrust(scenario):
        missing.set(f"{PLANT}.{thrust}.tilt", tilt)
    else:
        gravity *= share_across(tilt)
    missing.set(f"{PLANT}.gravity", gravity)
    missing.set(f"{PLANT}.gravity_angle", scenario.gravity_angle)
    if ACTUATOR in values.interfaces:
        missing.set(f"{ACTUATOR}.total_force", True)
        if not {f"{PLANT}.gravity", f"{ACTUATOR}.total_force"} & {*values.dropped}:
            _carry_weight(missing, scenario.rotor)
    return []


def _thrust(scenario: Scenario) -> str:
    """Return the thrust disc, which lets a rotor move axially, if the rotor is tilted and has one; otherwise empty."""
    if not tilt_of(scenario.tilt):
        return ""
    from rotor_analysis.rotor_file import load_rotor

    return load_rotor(scenario.rotor).thrust


def _assumed_loads(missing: MissingParameters) -> list[str]:
    """Return warnings if a scenario without gravity states data of magnets, but not the currents that carry loads."""
    values, kept = missing.values, dict[str, list[str]]()
    stated = {*missing.stated, *stated_constants(values, ACTUATOR)}
    for bearing, axis in magnet_axes(values):
        geometry = {f"{ACTUATOR}.{bearing}.{name}_{axis}" for name in GEOMETRY}
        static = f"{ACTUATOR}.{bearing}.static_current_{axis}"
        current = values.parameter(static)
        if current and geometry & stated and static not in stated and not is_measured(values):
            kept.setdefault(f"{current:g} A", []).append(f"{bearing}.{axis}")
    return [
        f"static_current = {current} of {', '.join(axes)} is a default that does not fit these magnets, and the "
        "scenario states no gravity; if the magnets carry no weight, as with a vertical shaft, set the current to 0 A "
        "or set gravity = 0"
        for current, axes in kept.items()
    ]


def _carry_weight(missing: MissingParameters, source: RotorSource) -> None:
    from rotor_analysis.rotor_file import load_rotor  # not needed without gravity

    values = missing.values
    size, angle = (values.parameter(f"{PLANT}.{name}") for name in ("gravity", "gravity_angle"))
    rotor = load_rotor(source)
    passive = tuple(
        (name, values.parameter(f"{PLANT}.{name}.k_b"))
        for name in (bearing.name for bearing in rotor.bearings)
        if not any(values.system.source_of(f"{PLANT}.{name}.f_{axis}") for axis in "xy")
    )
    tilt = 0.0
    if thrust := rotor.thrust:
        tilt = values.parameter(f"{PLANT}.{thrust}.tilt")
        if values.system.source_of(f"{PLANT}.{thrust}.f_z"):
            _carry(missing, thrust, "z", rotor.mass * size * math.sin(tilt))
    with one_blas_thread():
        carried = _carried(rotor, passive, values.inputs[SPEED] if rotor.seals else 0.0)
    upwards = np.array([-math.cos(angle), -math.sin(angle)])
    for bearing, mass in carried.items():
        load = 0.0 * upwards if bearing in dict(passive) else size * share_across(tilt) * mass @ upwards
        for axis, of_axis in zip("xy", load.tolist(), strict=True):
            _carry(missing, bearing, axis, of_axis)


@lru_cache(maxsize=8)
def _carried(rotor: Rotor, passive: tuple[tuple[str, float], ...], Omega: float) -> Mapping[str, Array]:
    """Return, by bearing, the tensor (kg) that maps gravity to load at a spin speed (rad/s); runs of a rotor share it.

    Bearings without a magnet's force act as springs with the stiffness (N/m) in `passive`.
    """
    from rotor_analysis.static_load import carried_with_seals

    return carried_with_seals(rotor, dict(passive), Omega)


def _carry(missing: MissingParameters, bearing: str, axis: str, load: float) -> None:
    """Set the currents of an axis that carries a load (N), according to (1)."""
    from amb_cosim.model_constants.magnetic_bearing import axis_parameters, static_current_for

    values, static = missing.values, f"{ACTUATOR}.{bearing}.static_current_{axis}"
    law = int(values.parameter(f"{ACTUATOR}.force_law"))
    if static in missing.stated:
        return
    unloaded = {**parameters_of(values, bearing, axis), "static_current": 0.0}
    try:
        current = static_current_for(abs(load), axis_parameters(bearing, axis, **unloaded), law)
    except ValueError as error:
        magnet = ", ".join(f"{name}_{axis} = {unloaded[name]:g} {unit}".rstrip() for name, unit in OF_MAGNET)
        raise ValueError(
            f"gravity: {bearing}.{axis} cannot carry its share of the weight: {error}; {bearing} has {magnet}"
        ) from error
    missing.set(static, math.copysign(current, load) if current else 0.0)
    if load < 0.0 and current and not values.drops(static, "parameter"):
        bias = unloaded["bias_current"] + current
        values.set_or_drop(f"{ACTUATOR}.{bearing}.bias_current_{axis}", bias, only="parameter")
