"""Quantities and plots that only the thesis's statements use, from runs of its rig and from its studies."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np

from amb_assessment.reporting.panels import Curve, Panel, curve, horizontal_axis
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.system.values import quantity
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants
from amb_cosim.results.contact_history import contact_cycles
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import signal
from amb_files.toml import validate
from bath_thesis.meshes import even_nodes
from bath_thesis.studies.contact_hysteresis import ContactLaws
from bath_thesis.studies.frequency_tables import COUNT, MeshAndCondensation
from bath_thesis.studies.h_interpolation import InverseReceptance
from bath_thesis.studies.identification_force import INTENDED, IdentificationForce
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
ROUNDING = 1e-11  # smallest relative error of H in plots
FLOOR = 1e-5  # %; smaller errors are drawn there
REFERENCE = "23_node"  # mesh that the thesis compares with, with consistent mass


def coil_cutoff(inputs: ModelInputs) -> Annotated[float, "rad/s"]:
    """Return the cut-off frequency R/L (rad/s) of a coil pair (2.1)."""
    return start_of(inputs, "amb_actuator", "mb1.resistance_x") / start_of(inputs, "amb_actuator", "mb1.inductance_x")


def frequencies(tables: MeshAndCondensation, mesh: str, mass: str, speed: float) -> Annotated[list[float], "rad/s"]:
    """Return the natural frequencies (rad/s) of a mesh (`13_node`, `condensed`) and mass matrix at a speed (rad/s)."""
    if mesh == "condensed" and mass == "diagonal":
        return list(tables.frequencies.condensed[f"{speed:g}"]["condensed"])
    if mesh == "condensed":
        rotor = load_rotor("bath_rig_thesis")
        model = supported_rotor(rotor, "consistent", rotor.masters).model
        return [float(frequency) for frequency in damped_frequencies(model, speed, COUNT)]
    return list(tables.frequencies.by_mesh[mesh][mass][f"{speed:g}"])


def frequency_errors(
    tables: MeshAndCondensation,
    mesh: str,
    mass: str,
    speed: float,
    reference: str = REFERENCE,
    reference_mass: str = "",
) -> Annotated[list[float], "1"]:
    """Return the relative deviations (1) of frequencies from those of another model, at one speed (rad/s).

    `reference` is the mesh of the other model; its mass matrix is `reference_mass`, by default the consistent one.
    """
    exact = frequencies(tables, reference, reference_mass or "consistent", speed)
    approximate = frequencies(tables, mesh, mass, speed)
    return [a / b - 1.0 for a, b in zip(approximate, exact, strict=True)]


def error_sizes(tables: MeshAndCondensation, mesh: str, mass: str, speed: float) -> Annotated[list[float], "1"]:
    """Return the absolute values (1) of `frequency_errors`."""
    return [abs(error) for error in frequency_errors(tables, mesh, mass, speed)]


def mean_error(tables: MeshAndCondensation, mesh: str, mass: str) -> Annotated[float, "1"]:
    """Return the mean absolute value (1) of `frequency_errors` over eight frequencies and three speeds."""
    errors = [frequency_errors(tables, mesh, mass, speed) for speed in (90.0, 120.0, 145.0)]
    return float(np.mean(np.abs(errors)))


def largest_error(
    tables: MeshAndCondensation, mesh: str, mass: str, reference: str, reference_mass: str
) -> Annotated[float, "1"]:
    """Return the largest absolute value (1) of `frequency_errors` over all frequencies and three speeds."""
    errors = [frequency_errors(tables, mesh, mass, s, reference, reference_mass) for s in (90.0, 120.0, 145.0)]
    return float(np.max(np.abs(errors)))


def negative_stiffness(inputs: ModelInputs) -> Annotated[float, "N/m"]:
    """Return K_s (N/m) of the linear law (2.8)."""
    return linear_constants(axis_parameters())[0]


def current_stiffness(inputs: ModelInputs) -> Annotated[float, "N/A"]:
    """Return K_i (N/A) of the linear law (2.9)."""
    return linear_constants(axis_parameters())[1]


def h_norm(result: InverseReceptance, frequency: float) -> Annotated[float, "N/m"]:
    """Return the Frobenius norm (N/m) of H at a speed (Hz) (5.10)."""
    nearest = int(np.argmin(np.abs(np.asarray(result.spin_frequencies) - frequency)))
    return float(np.linalg.norm(result.h[nearest]))


def h_row_norms(result: InverseReceptance, frequency: float) -> Annotated[list[float], "N/m"]:
    """Return the norm (N/m) of the row of H for each force, at a speed (Hz)."""
    nearest = int(np.argmin(np.abs(np.asarray(result.spin_frequencies) - frequency)))
    return [float(value) for value in np.linalg.norm(result.h[nearest], axis=1)]


def test_amplitude(force: IdentificationForce, frequency: float) -> Annotated[float, "N"]:
    """Return the amplitude A = 220 N/S (N) of the test force at a frequency (Hz) (6.5)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.amplitude))


def force_rule(force: IdentificationForce, frequency: float) -> Annotated[float, "1"]:
    """Return the piecewise linear S (1) at a frequency (Hz) (5.19, 6.6)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.s))


def slot_periods(force: IdentificationForce, frequency: float) -> Annotated[float, "1"]:
    """Return the number of revolutions in a slot of an identification at a frequency (Hz) (6.4)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.periods_per_slot))


def table_speeds(force: IdentificationForce) -> Annotated[list[float], "rad/s"]:
    """Return the speeds (rad/s) at which H is identified and stored."""
    return [HERTZ * float(f) for f in force.at_the_speeds_of_the_thesis.frequencies]


def test_response(force: IdentificationForce, frequency: float) -> Annotated[float, "m"]:
    """Return the amplitude (m) of the journal in MB1 along x under the test force at a frequency (Hz)."""
    return float(np.interp(frequency, force.columns.frequencies, force.columns.response_mb1))


def measured_norm(result: SynchronousResponse, axis: int, frequency: float) -> Annotated[float, "m/N"]:
    """Return the norm (m/N) of a column of the receptance that a co-simulation identified at a speed (Hz) (5.18)."""
    nearest = int(np.argmin(np.abs(np.asarray(result.at_speeds.spin_frequencies) - frequency)))
    return float(result.at_speeds.measured[nearest, axis])


def critical_speed_shift(result: ModelReduction, model: str) -> Annotated[float, "1"]:
    """Return the largest relative difference (1) between a critical speed of a model and that of the full model."""
    return _largest_shift(result, result.models[model].critical_speeds)


def critical_speed_shift_of_even_nodes(result: ModelReduction) -> Annotated[float, "1"]:
    """Return the largest relative change (1) of a critical speed if six equidistant nodes with lumped mass are used."""
    model = supported_rotor(even_nodes(load_rotor("bath_rig_thesis")), "diagonal").model
    crossings = campbell(model, result.speeds, COUNT).critical_speeds
    return _largest_shift(result, [crossing.Omega for crossing in crossings])


def _largest_shift(result: ModelReduction, others: Sequence[float]) -> float:
    """Return the largest relative deviation of critical speeds (rad/s) from those of the full model, in order."""
    exact = result.models[FULL].critical_speeds
    return max(abs(other / full - 1.0) for full, other in zip(exact, others, strict=False))


def response_error(result: ModelReduction, model: str) -> Annotated[float, "1"]:
    """Return the largest relative deviation (1) of the unbalance response from that of the full model."""
    return 0.01 * result.largest_response_error[model]


FASTEST = 300.0  # rad/s; largest critical speed


def critical_speeds(run: Signals, count: int) -> Annotated[list[float], "rad/s"]:
    """Return the lowest critical speeds (rad/s) with forward whirl, on bearings with the control gains of MB1 in x."""
    k_b, c_b = (parameter(run, "rolac_controller", f"mb1.{gain}_x") or 0.0 for gain in ("k_b", "c_b"))
    data = json.loads(run.attrs["scenario_data"]).get("rotor")
    rotor = validate(data, Rotor, "rotor of the run") if isinstance(data, dict) else load_rotor(data)
    rotor = rotor.on_equal_bearings(k_b, c_b)
    diagram = campbell(supported_rotor(rotor).model, np.linspace(0.0, FASTEST, 121), 2 * count)
    return [crossing.Omega for crossing in diagram.critical_speeds if crossing.whirl == "forward"][:count]


def step_of_unbalance(run: Signals, disc: str) -> Annotated[list[float], "kg.m"]:
    """Return the unbalance (kg m) of a disc before the scenario's disturbance, and the unbalance that is added."""
    data = json.loads(run.attrs["scenario_data"])
    factor, name = data.get("unbalance_factor", 1.0), f"{disc}.u"
    (step,) = (event for event in data["event"] if event.get("role") == "disturbance")
    before, after = (
        factor * quantity(table["rotor_contact"][name], "kg.m", name) for table in (data["inputs"], step["set"])
    )
    return [before, after - before]


def largest_remaining_share(run: Signals, planes: str = "s1,s3,s5,s7") -> Annotated[float | None, "1"]:
    """Return the largest ratio (1) of the final amplitude to that before ROLAC in `planes` (names of x sensors)."""
    chosen = [(x, y) for x, y in SENSOR_PLANES if x in planes.split(",")]
    pairs = [(sensor_amplitude(run, x, y, "before"), sensor_amplitude(run, x, y, "end")) for x, y in chosen]
    return max((after / before for before, after in pairs if before and after is not None), default=None)


def identified_norm(run: Signals) -> Annotated[float | None, "N/m"]:
    """Return the Frobenius norm (N/m) of H, from the receptance that the controller identified in the run (5.10)."""
    from amb_cosim.model_constants.controller_data import inverse_receptance

    axes = [f"{bearing}_{axis}" for bearing in places(run).bearings for axis in "xy"]
    names = [[f"rolac_controller.r.s{n}.{axis}" for axis in axes] for n in range(1, 9)]
    if any(f"{name}.re" not in run for row in names for name in row):
        return None
    R = np.array([[run[f"{n}.re"].values[-1] + 1j * run[f"{n}.im"].values[-1] for n in row] for row in names])
    return float(np.linalg.norm(inverse_receptance(R)))


def frequency_panels(result: MeshAndCondensation) -> list[Panel]:
    """Return plots of the frequency errors of all meshes, relative to the finest one, and of the condensed model."""
    meshes, condensed = result.frequencies.by_mesh, result.frequencies.condensed
    exact = np.array(next(iter(meshes.values()))["consistent"]["90"])
    rows = {
        f"{mesh.replace('_node', '')} nodes, {mass}": row["90"] for mesh, m in meshes.items() for mass, row in m.items()
    }
    rows |= {"condensed, diagonal": condensed["90"]["condensed"]} if condensed else {}
    number = np.arange(1, len(exact) + 1)
    errors = {name: 100.0 * (np.array(row) / exact[: len(row)] - 1.0) for name, row in rows.items()}
    curves = tuple(curve(name, number[: len(error)], error, "dots") for name, error in errors.items())
    panels = [Panel("Natural frequencies against the finest mesh, 90 rad/s", "frequency number", "error (%)", curves)]
    if (error := result.condensation) is not None:
        curves = tuple(curve(f"mode {k}", error.speeds, row) for k, row in enumerate(error.frequency_error, start=1))
        planes = ", ".join(map(str, error.planes))
        panels.append(Panel(f"Condensed to nodes {planes}", "spin speed (rad/s)", "error (%)", curves))
    return panels


def h_panels(result: InverseReceptance) -> list[Panel]:
    """Return plots of norms and interpolation errors of H, R's condition number, and printed and computed H (10 Hz)."""
    exact, between = (1e-6 * np.linalg.norm(h, axis=(1, 2)) for h in (result.h, result.h_interpolated))
    spins = result.spin_frequencies
    norms = [curve("exact", spins, exact), curve("interpolated", spins, between, "dashed")]
    norms += [curve(name, spins, 1e-6 * row) for name, row in zip(result.forces, result.norm_by_force.T, strict=True)]
    errors = [
        curve(f"{name.replace('_', ' ')}: {what}", spins, 100.0 * np.where(error > ROUNDING, error, np.nan))
        for name, table in result.tables.items()
        for what, error in (("H", table.relative_error), ("I + H R", table.left_by_a_step))
    ]
    condition = (curve("R", spins, result.condition_number),)
    panels = [
        Panel("Norm of H and of its rows", "spin speed (Hz)", "|H| (N/um)", tuple(norms)),
        Panel("Error of the interpolated H", "spin speed (Hz)", "error (%)", tuple(errors), log="y"),
        Panel("Condition number of R", "spin speed (Hz)", "condition number", condition),
    ]
    if (at := result.at_10_hz) is not None:
        elements = [
            curve(f"{force}, {what}", np.arange(1, H.shape[1] + 1), 1e-6 * H[k], "dots")
            for k, force in enumerate(at.forces)
            if force.endswith("x")
            for what, H in (("computed", at.computed), ("printed", at.printed))
        ]
        panels.append(Panel("Elements of H at 10 Hz", "signal", "|H_ij| (N/um)", tuple(elements)))
    return panels


def force_panels(result: IdentificationForce) -> list[Panel]:
    """Return plots of the test force (amplitude, S, revolutions in a slot, duration) and the journals' motion."""
    columns, thesis = result.columns, result.at_the_speeds_of_the_thesis
    in_range = thesis.frequencies <= columns.frequencies[-1]

    def over_frequency(title: str, label: str, name: str) -> Panel:
        at_speeds = curve("speeds of the thesis", thesis.frequencies[in_range], getattr(thesis, name)[in_range], "dots")
        computed = curve("controller", columns.frequencies, getattr(columns, name))
        return Panel(title, "frequency (Hz)", label, (computed, at_speeds))

    amplitudes = {"MB1": columns.response_mb1, "MB2": columns.response_mb2}
    responses = [curve(name, columns.frequencies, 1e3 * amplitude) for name, amplitude in amplitudes.items()]
    responses.append(curve("intended", columns.frequencies[[0, -1]], np.full(2, 1e3 * INTENDED), "dashed"))
    return [
        over_frequency("Test force", "A (N)", "amplitude"),
        over_frequency("Divisor of the force (6.6)", "S", "s"),
        over_frequency("Periods of a slot", "N_per", "periods_per_slot"),
        over_frequency("Duration of an identification", "t_halt (s)", "t_halt"),
        Panel("Motion caused by the test force", "frequency (Hz)", "amplitude (mm)", tuple(responses)),
    ]


def norm_panels(result: SynchronousResponse) -> list[Panel]:
    """Return plots of the response's norm against spin speed, the lines of (5.19), and the identified norm (5.18)."""
    at = result.at_speeds
    curves = [curve("(5.19)", result.spin_frequencies, 1e6 * result.thesis, "dashed")]
    for k in range(0, len(result.forces), 2):
        curves.append(curve(f"model, {result.forces[k]}", result.spin_frequencies, 1e6 * result.norm[:, k]))
        without = 1e6 * result.norm_without_conjugate[:, k]
        curves.append(curve(f"{result.forces[k]}, (5.18) without the conjugate", result.spin_frequencies, without))
    for k in range(0, len(result.forces), 2):
        curves.append(curve(f"identified, {result.forces[k]}", at.spin_frequencies, 1e6 * at.measured[:, k], "dots"))
    panel = Panel("Norm of the columns of R", "spin speed (Hz)", "|R_i| (um/N)", tuple(curves))
    return [panel, replace(panel, log="y")]


def reduction_panels(result: ModelReduction) -> list[Panel]:
    """Return plots of frequencies and response of the full, condensed and 6-node models against spin speed."""
    frequencies, responses, errors = [], [], []
    full = result.models[FULL].displacement
    for model, over_speed in result.models.items():
        name = f"{model.replace('_', ' ')}, {over_speed.coordinates} coordinates"
        speeds = np.tile(np.append(result.speeds, np.nan), len(over_speed.frequencies))
        rows = np.hstack([np.append(row, np.nan) for row in over_speed.frequencies])
        frequencies.append(Curve(name, speeds, rows))
        responses.append(curve(name, result.speeds, 1e3 * over_speed.displacement))
        if model != FULL:
            error = 100.0 * np.abs(over_speed.displacement / full - 1.0)
            errors.append(curve(name, result.speeds, np.maximum(error, FLOOR)))
    frequencies.append(curve("synchronous", result.speeds, result.speeds, "dashed"))
    speed, title = "spin speed (rad/s)", f"Largest response to {1e3 * result.unbalance:.3g} g m on D1"
    return [
        Panel("Damped natural frequencies", speed, "frequency (rad/s)", tuple(frequencies)),
        Panel(title, speed, "amplitude (mm)", tuple(responses), log="y"),
        Panel("Response compared with the full model", speed, "error (%)", tuple(errors), log="y"),
    ]


def force_at_touch(result: ContactLaws, law: str) -> Annotated[float, "N"]:
    """Return the force (N) of a contact law at the first touch, which is point A of Fig. 4.1."""
    return result.laws[law].force_at_touch


def smallest_force(result: ContactLaws, law: str) -> Annotated[float, "N"]:
    """Return the smallest force (N) of a contact law in an impact; if negative, it is point B of Fig. 4.1."""
    return result.laws[law].smallest_force


def law_panels(result: ContactLaws) -> list[Panel]:
    """Return a plot of force against penetration in an impact, for each contact law."""
    curves = (
        curve(f"{name.replace('_', ' ')} ({loop.equation})", 1e6 * loop.penetration, 1e-3 * loop.force)
        for name, loop in result.laws.items()
    )
    return [Panel("Contact laws in an impact", "penetration (um)", "force (kN)", tuple(curves))]


def end_panels(run: Signals) -> Iterator[Panel]:
    """Yield a plot of the radial displacement of the shaft's ends, if the run is without contact."""
    if contact_cycles(run)[0] is not None:
        return
    axis, label, drawn = horizontal_axis(run)
    ends = [(name, signal(run, x), signal(run, y)) for name, (x, y) in END_PLANES.items()]
    radii = [(name, np.hypot(x, y)[drawn]) for name, x, y in ends if x is not None and y is not None]
    if radii:
        curves = tuple(curve(name, axis, 1e3 * r) for name, r in radii)
        yield Panel("Radial displacement of the shaft's ends", label, "r (mm)", curves)
