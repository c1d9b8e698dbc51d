"""Quantities and plots for the thesis's statements only: of runs of its rig, and of its studies."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Annotated

import numpy as np

from amb_assessment.reporting.panels import Curve, Panel, curve, horizontal_axis
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.contact_history import contact_cycles
from amb_cosim.results.places import places
from amb_cosim.results.series import signal
from amb_files.toml import validate
from bath_thesis.studies.contact_hysteresis import ContactLaws
from bath_thesis.studies.frequency_tables import COUNT, ThesisTables
from bath_thesis.studies.h_interpolation import InverseReceptance
from bath_thesis.studies.identification_force import IdentificationForce
from bath_thesis.studies.measured_response import SynchronousResponse
from bath_thesis.studies.reduced_models import FULL, ModelReduction
from rotor_analysis.campbell import campbell
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor
from source_check.run_quantities import parameter, sensor_amplitude
from source_check.study_quantities import ModelInputs
from source_check.study_quantities import parameter as start_of

SENSOR_PLANES = [(f"s{n}", f"s{n + 1}") for n in (1, 3, 5, 7)]
END_PLANES = {"motor end": ("s1", "s2"), "non-driven end": ("s7", "s8")}
HERTZ = 2.0 * np.pi  # rad/s
REFERENCE = "23_node"  # mesh that the thesis compares with, with consistent mass


def coil_cutoff(inputs: ModelInputs) -> Annotated[float, "rad/s"]:
    """Return the cut-off frequency of a coil pair, R/L (rad/s) (2.1)."""
    return start_of(inputs, "amb_actuator", "mb1.resistance_x") / start_of(inputs, "amb_actuator", "mb1.inductance_x")


def frequencies(tables: ThesisTables, mesh: str, mass: str, speed: float) -> Annotated[list[float], "rad/s"]:
    """Return natural frequencies (rad/s) by mesh (`13_node`, `condensed`), mass matrix and spin speed (rad/s)."""
    if mesh == "condensed" and mass == "diagonal":
        return list(tables.frequencies.condensed[f"{speed:g}"]["condensed"])
    if mesh == "condensed":
        rotor = load_rotor("bath_rig_thesis")
        model = supported_rotor(rotor, "consistent", rotor.masters).model
        return [float(frequency) for frequency in damped_frequencies(model, speed, COUNT)]
    return list(tables.frequencies.by_mesh[mesh][mass][f"{speed:g}"])


def frequency_errors(
    tables: ThesisTables, mesh: str, mass: str, speed: float, reference: str = REFERENCE, reference_mass: str = ""
) -> Annotated[list[float], "1"]:
    """Return the relative deviations of frequencies from those of another model, at one speed (rad/s) (1).

    `reference` is a mesh, with consistent mass unless `reference_mass` says otherwise.
    """
    exact = frequencies(tables, reference, reference_mass or "consistent", speed)
    result = frequencies(tables, mesh, mass, speed)
    return [a / b - 1.0 for a, b in zip(result, exact, strict=True)]


def error_sizes(tables: ThesisTables, mesh: str, mass: str, speed: float) -> Annotated[list[float], "1"]:
    """Return the absolute values of `frequency_errors` (1)."""
    return [abs(error) for error in frequency_errors(tables, mesh, mass, speed)]


def mean_error(tables: ThesisTables, mesh: str, mass: str) -> Annotated[float, "1"]:
    """Return the mean absolute value of `frequency_errors` over eight frequencies and three speeds (1)."""
    errors = [frequency_errors(tables, mesh, mass, speed) for speed in (90.0, 120.0, 145.0)]
    return float(np.mean(np.abs(errors)))


def largest_error(
    tables: ThesisTables, mesh: str, mass: str, reference: str, reference_mass: str
) -> Annotated[float, "1"]:
    """Return the largest absolute value of `frequency_errors` over three speeds (1)."""
    errors = [frequency_errors(tables, mesh, mass, s, reference, reference_mass) for s in (90.0, 120.0, 145.0)]
    return float(np.max(np.abs(errors)))


def negative_stiffness(tables: ThesisTables) -> Annotated[float, "N/m"]:
    """Return K_s of the linear law (N/m) (2.8)."""
    return tables.bearing_constants.k_s


def current_stiffness(tables: ThesisTables) -> Annotated[float, "N/A"]:
    """Return K_i of the linear law (N/A) (2.9)."""
    return tables.bearing_constants.k_i


def h_norm(result: InverseReceptance, frequency: float) -> Annotated[float, "N/m"]:
    """Return the Frobenius norm of H at a speed (Hz) (N/m) (5.10)."""
    at = int(np.argmin(np.abs(np.asarray(result.speeds) - frequency)))
    return float(np.linalg.norm(result.h[at]))


def h_row_norms(result: InverseReceptance, frequency: float) -> Annotated[list[float], "N/m"]:
    """Return the norm of each row of H, one for each force, at a speed (Hz) (N/m)."""
    at = int(np.argmin(np.abs(np.asarray(result.speeds) - frequency)))
    return [float(value) for value in np.linalg.norm(result.h[at], axis=1)]


def test_amplitude(force: IdentificationForce, frequency: float) -> Annotated[float, "N"]:
    """Return the amplitude of the test force at a frequency (Hz), A = 220 N/S (N) (6.5)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.amplitude))


def force_rule(force: IdentificationForce, frequency: float) -> Annotated[float, "1"]:
    """Return the piecewise linear S at a frequency (Hz) (1) (5.19, 6.6)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.s))


def slot_periods(force: IdentificationForce, frequency: float) -> Annotated[float, "1"]:
    """Return the revolutions of a slot of an identification at a frequency (Hz) (6.4)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.periods_per_slot))


def table_speeds(force: IdentificationForce) -> Annotated[list[float], "rad/s"]:
    """Return the speeds at which H is identified and stored (rad/s)."""
    return [HERTZ * float(f) for f in force.at_the_speeds_of_the_thesis.frequencies]


def test_response(force: IdentificationForce, frequency: float) -> Annotated[float, "m"]:
    """Return the amplitude of the journal in MB1 in x under the test force at a frequency (Hz) (m)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.response_mb1))


def measured_norm(result: SynchronousResponse, axis: int, frequency: float) -> Annotated[float, "m/N"]:
    """Return the norm of a column of the receptance identified in a co-simulation at a speed (Hz) (m/N) (5.18)."""
    at = int(np.argmin(np.abs(np.asarray(result.at_speeds.speeds) - frequency)))
    return float(result.at_speeds.measured[at, axis])


def critical_speed_shift(result: ModelReduction, model: str) -> Annotated[float, "1"]:
    """Return the largest change of a critical speed, of those of the full model, by another model (1)."""
    exact, other = (np.array(result.models[name].critical_speeds) for name in (FULL, model))
    count = min(len(exact), len(other))
    return float(np.max(np.abs(other[:count] / exact[:count] - 1.0)))


def response_error(result: ModelReduction, model: str) -> Annotated[float, "1"]:
    """Return the largest deviation of the response to unbalance from that of the full model (1)."""
    return 0.01 * result.largest_response_error[model]


FASTEST = 300.0  # rad/s, up to which critical speeds are looked for


def critical_speeds(run: Signals, count: int) -> Annotated[list[float], "rad/s"]:
    """Return the lowest critical speeds with forward whirl (rad/s) on bearings with the gains of axis x of MB1."""
    k_b, c_b = (parameter(run, "rolac_controller", f"mb1.{gain}_x") or 0.0 for gain in ("k_b", "c_b"))
    stated = json.loads(run.attrs["scenario_data"]).get("rotor")
    rotor = validate(stated, Rotor, "rotor of the run") if isinstance(stated, dict) else load_rotor(stated)
    rotor = rotor.on_equal_bearings(k_b, c_b)
    result = campbell(supported_rotor(rotor).model, np.linspace(0.0, FASTEST, 121), 2 * count)
    return [crossing.Omega for crossing in result.critical_speeds if crossing.whirl == "forward"][:count]


def largest_remaining_share(run: Signals, planes: str = "s1,s3,s5,s7") -> Annotated[float | None, "1"]:
    """Return the largest amplitude at the end over that before ROLAC's beginning (1), of planes by their x sensors."""
    chosen = [(x, y) for x, y in SENSOR_PLANES if x in planes.split(",")]
    pairs = [(sensor_amplitude(run, x, y, "before"), sensor_amplitude(run, x, y, "end")) for x, y in chosen]
    return max((after / before for before, after in pairs if before and after is not None), default=None)


def identified_norm(run: Signals) -> Annotated[float | None, "N/m"]:
    """Return the Frobenius norm (N/m) of H from the receptance that the controller identified in the run (5.10)."""
    from amb_cosim.design.controller_data import inverse_receptance

    axes = [f"{bearing}_{axis}" for bearing in places(run).bearings for axis in "xy"]
    names = [[f"rolac_controller.r.s{n}.{axis}" for axis in axes] for n in range(1, 9)]
    if any(f"{name}.re" not in run for row in names for name in row):
        return None
    R = np.array([[run[f"{n}.re"].values[-1] + 1j * run[f"{n}.im"].values[-1] for n in row] for row in names])
    return float(np.linalg.norm(inverse_receptance(R)))


def frequency_panels(result: ThesisTables) -> list[Panel]:
    """Return the error of each mesh against the finest with consistent mass, at 90 rad/s."""
    meshes = result.frequencies.by_mesh
    exact = np.array(meshes["23_node"]["consistent"]["90"])
    rows = {
        f"{mesh.replace('_node', '')} nodes, {mass}": row["90"] for mesh, m in meshes.items() for mass, row in m.items()
    }
    rows["condensed, diagonal"] = result.frequencies.condensed["90"]["condensed"]
    number = np.arange(1, len(exact) + 1)
    curves = tuple(curve(name, number, 100.0 * (np.array(row) / exact - 1.0), "dots") for name, row in rows.items())
    return [Panel("Natural frequencies against 23 nodes, consistent mass", "frequency number", "error (%)", curves)]


def h_panels(result: InverseReceptance) -> list[Panel]:
    """Return the norm of H, exact and interpolated, over the spin speed."""
    exact, between = (1e-6 * np.linalg.norm(h, axis=(1, 2)) for h in (result.h, result.h_interpolated))
    curves = (curve("exact", result.speeds, exact), curve("interpolated", result.speeds, between, "dashed"))
    return [Panel("Norm of H", "spin speed (Hz)", "|H| (N/um)", curves)]


def force_panels(result: IdentificationForce) -> list[Panel]:
    """Return the amplitude of the test force, and of the journals under it, over the frequency."""
    columns = result.columns
    moved = {"MB1": columns.response_mb1, "MB2": columns.response_mb2}
    responses = tuple(curve(name, columns.frequencies, 1e3 * response) for name, response in moved.items())
    return [
        Panel("Test force", "frequency (Hz)", "A (N)", (curve("A", columns.frequencies, columns.amplitude),)),
        Panel("Motion by the test force", "frequency (Hz)", "amplitude (mm)", responses),
    ]


def norm_panels(result: SynchronousResponse) -> list[Panel]:
    """Return the norm of the response over the spin speed, the lines of (5.19), and the identified norm (5.18)."""
    at = result.at_speeds
    curves = [curve("(5.19)", result.speeds, 1e6 * result.thesis, "dashed")]
    for k in range(0, len(result.forces), 2):
        curves.append(curve(f"model, {result.forces[k]}", result.speeds, 1e6 * result.norm[:, k]))
    for k in range(0, len(result.forces), 2):
        curves.append(curve(f"identified, {result.forces[k]}", at.speeds, 1e6 * at.measured[:, k], "dots"))
    return [Panel("Norm of the columns of R", "spin speed (Hz)", "|R_i| (um/N)", tuple(curves))]


def reduction_panels(result: ModelReduction) -> list[Panel]:
    """Return frequencies and response of the full, the condensed and the 6-node model over the spin speed."""
    frequencies = []
    for name, model in result.models.items():
        speeds = np.tile(np.append(result.speeds, np.nan), len(model.frequencies))
        rows = np.hstack([np.append(row, np.nan) for row in model.frequencies])
        frequencies.append(Curve(name.replace("_", " "), speeds, rows))
    responses = (
        curve(name.replace("_", " "), result.speeds, 1e3 * m.displacement) for name, m in result.models.items()
    )
    return [
        Panel("Damped natural frequencies", "spin speed (rad/s)", "frequency (rad/s)", tuple(frequencies)),
        Panel("Largest response to 0.5 g m on D1", "spin speed (rad/s)", "amplitude (mm)", tuple(responses)),
    ]


def force_at_touch(result: ContactLaws, law: str) -> Annotated[float, "N"]:
    """Return the force of a contact law at the first touch (N), point A of Fig. 4.1."""
    return result.laws[law].force_at_touch


def smallest_force(result: ContactLaws, law: str) -> Annotated[float, "N"]:
    """Return the smallest force of a contact law in a blow (N), point B of Fig. 4.1 if negative."""
    return result.laws[law].smallest_force


def law_panels(result: ContactLaws) -> list[Panel]:
    """Return force over penetration of each contact law in one blow."""
    curves = (
        curve(f"{name.replace('_', ' ')} ({loop.equation})", 1e6 * loop.penetration, 1e-3 * loop.force)
        for name, loop in result.laws.items()
    )
    return [Panel("Contact laws in one blow", "penetration (um)", "force (kN)", tuple(curves))]


def end_panels(run: Signals) -> Iterator[Panel]:
    """Yield the radial displacement of the shaft's ends, of a run without contact."""
    if contact_cycles(run)[0] is not None:
        return
    axis, label, displayed = horizontal_axis(run)
    ends = [(name, signal(run, x), signal(run, y)) for name, (x, y) in END_PLANES.items()]
    seen = [(name, np.hypot(x, y)[displayed]) for name, x, y in ends if x is not None and y is not None]
    if seen:
        curves = tuple(curve(name, axis, 1e3 * r) for name, r in seen)
        yield Panel("Radial displacement of the shaft's ends", label, "r (mm)", curves)
