"""Named quantities of studies: each takes a study's result and returns a number in SI units, a list, a text or None."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from amb_cosim import studies
from amb_cosim.cosim.values import quantity
from amb_cosim.studies.bearing_axis import BearingAxis
from amb_cosim.studies.campbell_diagram import CampbellDiagram
from amb_cosim.studies.contact_hysteresis import ContactLaws
from amb_cosim.studies.frequency_tables import ThesisTables
from amb_cosim.studies.h_interpolation import InverseReceptance
from amb_cosim.studies.identification_force import IdentificationForce
from amb_cosim.studies.measured_response import SynchronousResponse
from amb_cosim.studies.natural_modes import ModeShapes
from amb_cosim.studies.reduced_models import FULL, ModelReduction
from amb_cosim.studies.rotor_layout import RotorLayout
from amb_cosim.studies.sensor_receptance import SensorReceptance
from rotor_analysis.frequency_tables import COUNT
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor

HERTZ = 2.0 * np.pi  # rad/s
REFERENCE = "23_node"  # mesh that the thesis compares with, with consistent mass
BEYOND_SATURATION = 1e4  # A


@dataclass(frozen=True)
class ModelInputs:
    """What the models take over from the thesis: start values of their parameters by component, and the rotor."""

    parameters: dict[str, dict[str, float]]
    rotor: Rotor


def model_inputs() -> ModelInputs:
    """Return the start values of all parameters of the three models, and the rotor of the thesis."""
    from amb_cosim.packaging import models

    made = {name: getattr(models, name)()[0] for name in models.MODELS}
    return ModelInputs(
        {
            name: {v.name: float(v.start) for v in model.interface.variables if v.causality == "parameter"}
            for name, model in made.items()
        },
        load_rotor(),
    )


def compute(study: str, arguments: dict[str, Any]) -> Any:
    """Return the result of a study of `amb_cosim.studies`, or of `model_inputs`.

    Raises
    ------
    ValueError
        If there is no such study, or an argument is out of range.
    """
    if study == "model_inputs":
        return model_inputs()
    if study not in studies.STUDIES:
        raise ValueError(f"there is no study {study!r}; there are {', '.join(studies.STUDIES)}, model_inputs")
    function = getattr(studies, study)
    quiet = {"progress": False} if "progress" in inspect.signature(function).parameters else {}
    return function(**arguments, **quiet)


def parameter(inputs: ModelInputs, component: str, name: str) -> float:
    """Return the start value of a parameter of a model, in its unit."""
    return inputs.parameters[component][name]


def shaft_diameter(inputs: ModelInputs) -> float:
    """Return the diameter of the shaft (m)."""
    (diameter,) = {*inputs.rotor.shaft.diameter}
    return float(diameter)


def body_count(inputs: ModelInputs, mass: float, radius: float) -> float:
    """Return the number of rigid bodies of a mass (kg) and a radius (m)."""
    return float(sum((body.mass, getattr(body, "radius", None)) == (mass, radius) for body in inputs.rotor.bodies))


def clearance(inputs: ModelInputs, site: str) -> float:
    """Return the clearance of a contact site of the rotor (m)."""
    return parameter(inputs, "rotor_contact", f"{site}.clearance")


def node_count(inputs: ModelInputs) -> float:
    """Return the number of nodes of the mesh."""
    return float(len(inputs.rotor.shaft.nodes))


def plane_count(inputs: ModelInputs) -> float:
    """Return the number of planes that the condensed model keeps."""
    return float(len(inputs.rotor.masters))


def rolling_ratio(inputs: ModelInputs, site: str) -> float:
    """Return the whirl speed of rolling over the spin speed, without sign, R_s/C_r (1) (4.30)."""
    return parameter(inputs, "rotor_contact", f"{site}.journal_radius") / clearance(inputs, site)


def coil_cutoff(inputs: ModelInputs) -> float:
    """Return the cut-off frequency of a coil pair, R/L (rad/s) (2.1)."""
    return parameter(inputs, "amb_actuator", "mb1.resistance_x") / parameter(inputs, "amb_actuator", "mb1.inductance_x")


def largest_force(inputs: ModelInputs) -> float:
    """Return the pull of a saturated coil pair at the nominal gap, both poles at an angle (N) (2.6)."""
    from amb_actuator.force import pull
    from amb_cosim.design.magnetic_bearing import axis_parameters

    axis = axis_parameters()
    return float(pull(axis, BEYOND_SATURATION, axis.gap).force)


def synchronous_force(inputs: ModelInputs, unbalance: str, speed: str) -> float:
    """Return the rotating force of an unbalance at a spin speed, both with their units, u Omega^2 (N)."""
    return quantity(unbalance, "kg.m", "unbalance") * quantity(speed, "rad/s", "speed") ** 2


def stiffness_at(inputs: ModelInputs, bias: float, static: float) -> float:
    """Return K_s of the linear law with a bias and a static current (A) (N/m) (2.8)."""
    from amb_cosim.design.magnetic_bearing import axis_parameters, linear_constants

    return linear_constants(axis_parameters(bias_current=bias, static_current=static))[0]


def static_load(axis: BearingAxis) -> float:
    """Return the static load of an axis at its static current (N)."""
    return axis.load.own.static_load


def frequencies(tables: ThesisTables, mesh: str, mass: str, speed: float) -> list[float]:
    """Return natural frequencies (rad/s) by mesh (`13_node`, `condensed`), mass matrix and spin speed (rad/s)."""
    if mesh == "condensed" and mass == "diagonal":
        return list(tables.frequencies.condensed[f"{speed:g}"]["condensed"])
    if mesh == "condensed":
        rotor = load_rotor()
        model = supported_rotor(rotor, "consistent", rotor.masters).model
        return [float(frequency) for frequency in damped_frequencies(model, speed, COUNT)]
    return list(tables.frequencies.by_mesh[mesh][mass][f"{speed:g}"])


def frequency_errors(
    tables: ThesisTables, mesh: str, mass: str, speed: float, reference: str = REFERENCE, reference_mass: str = ""
) -> list[float]:
    """Return frequencies over those of another model less one, at one speed (rad/s), with sign (1).

    `reference` is a mesh, with consistent mass unless `reference_mass` says otherwise.
    """
    exact = frequencies(tables, reference, reference_mass or "consistent", speed)
    found = frequencies(tables, mesh, mass, speed)
    return [a / b - 1.0 for a, b in zip(found, exact, strict=True)]


def error_sizes(tables: ThesisTables, mesh: str, mass: str, speed: float) -> list[float]:
    """Return the sizes of `frequency_errors` (1)."""
    return [abs(error) for error in frequency_errors(tables, mesh, mass, speed)]


def mean_error(tables: ThesisTables, mesh: str, mass: str) -> float:
    """Return the mean size of `frequency_errors` over eight frequencies and three speeds (1)."""
    errors = [frequency_errors(tables, mesh, mass, speed) for speed in (90.0, 120.0, 145.0)]
    return float(np.mean(np.abs(errors)))


def largest_error(tables: ThesisTables, mesh: str, mass: str, reference: str, reference_mass: str) -> float:
    """Return the largest size of `frequency_errors` over three speeds (1)."""
    errors = [frequency_errors(tables, mesh, mass, s, reference, reference_mass) for s in (90.0, 120.0, 145.0)]
    return float(np.max(np.abs(errors)))


def negative_stiffness(tables: ThesisTables) -> float:
    """Return K_s of the linear law (N/m) (2.8)."""
    return tables.bearing_constants.k_s


def current_stiffness(tables: ThesisTables) -> float:
    """Return K_i of the linear law (N/A) (2.9)."""
    return tables.bearing_constants.k_i


def mode_frequency(modes: ModeShapes, pair: int) -> float:
    """Return the mean of a pair of natural frequencies, backward and forward, counted from 1 (rad/s)."""
    found = modes.frequencies.speeds[modes.speed].frequencies
    return float(np.mean(found[2 * pair - 2 : 2 * pair]))


def mode_kind(modes: ModeShapes, pair: int) -> str:
    """Return what the shape of a pair of modes is: `conical`, `cylindrical`, or `flexural` with its crossings."""
    shape = modes.shapes[2 * pair - 2]
    return f"flexural, {shape.crossings} nodes" if shape.kind == "flexural" else shape.kind


def critical_speed(diagram: CampbellDiagram, number: int) -> float:
    """Return a critical speed with forward whirl, counted from 1 (rad/s)."""
    return critical_speeds(diagram, number)[number - 1]


def critical_speeds(diagram: CampbellDiagram, count: int) -> list[float]:
    """Return the lowest critical speeds with forward whirl (rad/s)."""
    return [row.speed for row in diagram.critical_speeds if row.whirl == "forward"][:count]


def rotor_mass(found: RotorLayout) -> float:
    """Return the mass of the rotor (kg)."""
    return found.mass


def rotor_length(found: RotorLayout) -> float:
    """Return the length of the shaft (m)."""
    return found.length


def column_norm(found: SensorReceptance, axis: int, frequency: float) -> float:
    """Return the norm of a column of the receptance at a speed (Hz), S_i = |R_i| (m/N) (5.18)."""
    at = int(np.argmin(np.abs(np.asarray(found.speeds) - frequency)))
    return float(np.linalg.norm(found.receptance[at][:, axis]))


def h_norm(found: InverseReceptance, frequency: float) -> float:
    """Return the Frobenius norm of H at a speed (Hz) (N/m) (5.10)."""
    at = int(np.argmin(np.abs(np.asarray(found.speeds) - frequency)))
    return float(np.linalg.norm(found.h[at]))


def h_row_norms(found: InverseReceptance, frequency: float) -> list[float]:
    """Return the norm of each row of H, one for each force, at a speed (Hz) (N/m)."""
    at = int(np.argmin(np.abs(np.asarray(found.speeds) - frequency)))
    return [float(value) for value in np.linalg.norm(found.h[at], axis=1)]


def test_amplitude(force: IdentificationForce, frequency: float) -> float:
    """Return the amplitude of the test force at a frequency (Hz), A = 220 N/S (N) (6.5)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.amplitude))


def force_rule(force: IdentificationForce, frequency: float) -> float:
    """Return the piecewise linear S at a frequency (Hz) (1) (5.19, 6.6)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.s))


def slot_periods(force: IdentificationForce, frequency: float) -> float:
    """Return the revolutions of a slot of an identification at a frequency (Hz) (6.4)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.periods_per_slot))


def table_speeds(force: IdentificationForce) -> list[float]:
    """Return the speeds at which H is identified and stored (rad/s)."""
    return [HERTZ * float(f) for f in force.at_the_speeds_of_the_thesis.frequencies]


def test_response(force: IdentificationForce, frequency: float) -> float:
    """Return how far the test force at a frequency (Hz) moves the journal in MB1 in x (m)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.response_mb1))


def measured_norm(found: SynchronousResponse, axis: int, frequency: float) -> float:
    """Return the norm of a column of the receptance identified in a co-simulation at a speed (Hz) (m/N) (5.18)."""
    at = int(np.argmin(np.abs(np.asarray(found.at_speeds.speeds) - frequency)))
    return float(found.at_speeds.measured[at, axis])


def critical_speed_shift(found: ModelReduction, model: str) -> float:
    """Return the largest change of a critical speed, of those of the full model, by another model (1)."""
    exact, other = (np.array(found.models[name].critical_speeds) for name in (FULL, model))
    count = min(len(exact), len(other))
    return float(np.max(np.abs(other[:count] / exact[:count] - 1.0)))


def response_error(found: ModelReduction, model: str) -> float:
    """Return the largest deviation of the response to unbalance from that of the full model (1)."""
    return 0.01 * found.largest_response_error[model]


def force_at_touch(found: ContactLaws, law: str) -> float:
    """Return the force of a contact law at the first touch (N), point A of Fig. 4.1."""
    return found.laws[law].force_at_touch


def smallest_force(found: ContactLaws, law: str) -> float:
    """Return the smallest force of a contact law in a blow (N), point B of Fig. 4.1 where it is negative."""
    return found.laws[law].smallest_force


QUANTITIES: dict[str, tuple[Callable[..., Any], str]] = {
    "parameter": (parameter, ""),
    "shaft_diameter": (shaft_diameter, "m"),
    "body_count": (body_count, "1"),
    "clearance": (clearance, "m"),
    "node_count": (node_count, "1"),
    "plane_count": (plane_count, "1"),
    "rolling_ratio": (rolling_ratio, "1"),
    "coil_cutoff": (coil_cutoff, "rad/s"),
    "largest_force": (largest_force, "N"),
    "stiffness_at": (stiffness_at, "N/m"),
    "static_load": (static_load, "N"),
    "synchronous_force": (synchronous_force, "N"),
    "frequencies": (frequencies, "rad/s"),
    "frequency_errors": (frequency_errors, "1"),
    "error_sizes": (error_sizes, "1"),
    "mean_error": (mean_error, "1"),
    "largest_error": (largest_error, "1"),
    "negative_stiffness": (negative_stiffness, "N/m"),
    "current_stiffness": (current_stiffness, "N/A"),
    "mode_frequency": (mode_frequency, "rad/s"),
    "mode_kind": (mode_kind, ""),
    "critical_speed": (critical_speed, "rad/s"),
    "critical_speeds": (critical_speeds, "rad/s"),
    "rotor_mass": (rotor_mass, "kg"),
    "rotor_length": (rotor_length, "m"),
    "column_norm": (column_norm, "m/N"),
    "h_norm": (h_norm, "N/m"),
    "h_row_norms": (h_row_norms, "N/m"),
    "test_amplitude": (test_amplitude, "N"),
    "force_rule": (force_rule, "1"),
    "slot_periods": (slot_periods, "1"),
    "table_speeds": (table_speeds, "rad/s"),
    "test_response": (test_response, "m"),
    "measured_norm": (measured_norm, "m/N"),
    "critical_speed_shift": (critical_speed_shift, "1"),
    "response_error": (response_error, "1"),
    "force_at_touch": (force_at_touch, "N"),
    "smallest_force": (smallest_force, "N"),
}
"""Each quantity with the unit of its number; empty for texts, truth values, and numbers in a unit of their own."""
