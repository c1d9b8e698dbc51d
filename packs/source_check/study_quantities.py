"""Quantities of studies; each is a function of a study's result that returns a number in SI units, a list or a text."""

from __future__ import annotations

import inspect
import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from amb_analysis.studies.bearing_axis import BearingAxis
from amb_analysis.studies.campbell_diagram import CampbellDiagram
from amb_analysis.studies.natural_modes import ModeShapes
from amb_analysis.studies.rotor_layout import RotorLayout
from amb_analysis.studies.sensor_receptance import SensorReceptance
from amb_cosim import studies
from amb_cosim.cosim.system.values import quantity
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

BEYOND_SATURATION = 1e4  # A


@dataclass(frozen=True)
class ModelInputs:
    """Start values of the models: the parameters of each component, and the rotor."""

    parameters: dict[str, dict[str, float]]
    rotor: Rotor


def model_inputs() -> ModelInputs:
    """Return the start values of all parameters of the three models, and their default rotor."""
    from amb_cosim.export import models

    by_name = {name: getattr(models, name)()[0] for name in models.MODELS}
    return ModelInputs(
        {
            name: {v.name: float(v.start) for v in model.interface.variables if v.causality == "parameter"}
            for name, model in by_name.items()
        },
        load_rotor(),
    )


def compute(study: str, arguments: dict[str, Any]) -> Any:
    """Return the result of a study of `amb_analysis.studies`, or of `model_inputs`.

    Raises
    ------
    ValueError
        If there is no such study, or an argument is out of range.
    """
    if study == "model_inputs":
        return model_inputs()
    if study not in studies.STUDIES:
        raise ValueError(f"there is no study {study!r}; it must be one of {', '.join(studies.STUDIES)}, model_inputs")
    function = getattr(studies, study)
    quiet = {"progress": False} if "progress" in inspect.signature(function).parameters else {}
    return function(**arguments, **quiet)


def parameter(inputs: ModelInputs, component: str, name: str) -> float:
    """Return the start value of a model's parameter, in the unit of the parameter."""
    return inputs.parameters[component][name]


def shaft_diameter(inputs: ModelInputs) -> Annotated[float, "m"]:
    """Return the diameter of the shaft (m)."""
    (diameter,) = {*inputs.rotor.shaft.diameter}
    return float(diameter)


def body_count(inputs: ModelInputs, mass: float, radius: float) -> Annotated[float, "1"]:
    """Return the number of rigid bodies with this mass (kg) and radius (m)."""
    return float(sum((body.mass, getattr(body, "radius", None)) == (mass, radius) for body in inputs.rotor.bodies))


def clearance(inputs: ModelInputs, site: str) -> Annotated[float, "m"]:
    """Return the clearance of a contact site of the rotor (m)."""
    return parameter(inputs, "rotor_contact", f"{site}.clearance")


def node_count(inputs: ModelInputs) -> Annotated[float, "1"]:
    """Return the number of nodes of the mesh."""
    return float(len(inputs.rotor.shaft.nodes))


def rolling_ratio(inputs: ModelInputs, site: str) -> Annotated[float, "1"]:
    """Return the ratio R_s/C_r (1) of the whirl speed of rolling to the spin speed, without its sign (4.30)."""
    return parameter(inputs, "rotor_contact", f"{site}.journal_radius") / clearance(inputs, site)


def largest_force(inputs: ModelInputs) -> Annotated[float, "N"]:
    """Return the pull (N) of a saturated coil pair at the nominal gap, including the angle of both poles (2.6)."""
    from amb_actuator.force import pull
    from amb_cosim.model_constants.magnetic_bearing import axis_parameters

    axis = axis_parameters()
    return float(pull(axis, BEYOND_SATURATION, axis.gap).force)


def synchronous_force(inputs: ModelInputs, unbalance: str, speed: str) -> Annotated[float, "N"]:
    """Return the rotating force u Omega^2 (N) of an unbalance at a spin speed, both given as strings with units."""
    return quantity(unbalance, "kg.m", "unbalance") * quantity(speed, "rad/s", "speed") ** 2


def stiffness_at(inputs: ModelInputs, bias: float, static: float) -> Annotated[float, "N/m"]:
    """Return K_s (N/m) of the linear law (2.8) for a bias current and a static current (A)."""
    from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants

    return linear_constants(axis_parameters(bias_current=bias, static_current=static))[0]


def static_load(axis: BearingAxis) -> Annotated[float, "N"]:
    """Return the static load (N) of an axis at its static current."""
    return axis.load.own.static_load


def static_weight(axis: BearingAxis) -> Annotated[float, "N"]:
    """Return the static weight (N) on a bearing, which two axes at 45 degrees carry at their static current."""
    return math.sqrt(2.0) * static_load(axis)


def mode_frequency(modes: ModeShapes, pair: int) -> Annotated[float, "rad/s"]:
    """Return the mean of the backward and forward natural frequencies (rad/s) of a pair; `pair` counts from 1."""
    frequencies = modes.frequencies.speeds[modes.speed].frequencies
    return float(np.mean(frequencies[2 * pair - 2 : 2 * pair]))


def mode_kind(modes: ModeShapes, pair: int) -> str:
    """Return the kind of a pair of modes: `conical`, `cylindrical`, or `flexural` with the number of its nodes."""
    shape = modes.shapes[modes.speed][2 * pair - 2]
    return f"flexural, {shape.crossings} nodes" if shape.kind == "flexural" else shape.kind


def critical_speed(diagram: CampbellDiagram, number: int) -> Annotated[float, "rad/s"]:
    """Return a critical speed (rad/s) with forward whirl; `number` counts from 1."""
    return critical_speeds(diagram, number)[number - 1]


def critical_speeds(diagram: CampbellDiagram, count: int) -> Annotated[list[float], "rad/s"]:
    """Return the lowest critical speeds (rad/s) with forward whirl."""
    return [row.speed for row in diagram.critical_speeds if row.whirl == "forward"][:count]


def rotor_mass(result: RotorLayout) -> Annotated[float, "kg"]:
    """Return the mass of the rotor (kg)."""
    return result.mass


def rotor_length(result: RotorLayout) -> Annotated[float, "m"]:
    """Return the length of the shaft (m)."""
    return result.length


def column_norm(result: SensorReceptance, axis: int, frequency: float) -> Annotated[float, "m/N"]:
    """Return the norm S_i = |R_i| (m/N) of a column of the receptance at a speed (Hz) (5.18)."""
    nearest = int(np.argmin(np.abs(np.asarray(result.spin_frequencies) - frequency)))
    return float(np.linalg.norm(result.receptance[nearest][:, axis]))
