"""Plots of studies, as data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from amb_cosim.report.panels import Curve, Panel, curve
from amb_cosim.studies.campbell_diagram import CampbellDiagram
from amb_cosim.studies.contact_hysteresis import ContactLaws
from amb_cosim.studies.frequency_tables import ThesisTables
from amb_cosim.studies.h_interpolation import InverseReceptance
from amb_cosim.studies.identification_force import IdentificationForce
from amb_cosim.studies.measured_response import SynchronousResponse
from amb_cosim.studies.natural_modes import ModeShapes
from amb_cosim.studies.reduced_models import ModelReduction
from amb_cosim.studies.sensor_receptance import SensorReceptance
from amb_cosim.studies.unbalance_over_speed import UnbalanceResponse

SHOWN_MODES = 8


def study_panels(result: Any) -> tuple[Panel, ...]:
    """Return the plots of a study's result; none where a study has no curves."""
    return next((tuple(draw(result)) for form, draw in PANELS.items() if isinstance(result, form)), ())


def campbell_panels(found: CampbellDiagram) -> list[Panel]:
    """Return natural frequencies over the spin speed, and the line of synchronous speed."""
    modes = [curve(f"mode {k}", found.speeds, mode.frequencies) for k, mode in enumerate(found.modes, start=1)]
    synchronous = curve("synchronous", found.speeds, found.speeds, "dashed")
    return [Panel("Damped natural frequencies", "spin speed (rad/s)", "frequency (rad/s)", (*modes, synchronous))]


def frequency_panels(found: ThesisTables) -> list[Panel]:
    """Return the error of each mesh against the finest with consistent mass, at 90 rad/s."""
    meshes = found.frequencies.by_mesh
    exact = np.array(meshes["23_node"]["consistent"]["90"])
    rows = {
        f"{mesh.replace('_node', '')} nodes, {mass}": row["90"] for mesh, m in meshes.items() for mass, row in m.items()
    }
    rows["condensed, diagonal"] = found.frequencies.condensed["90"]["condensed"]
    number = np.arange(1, len(exact) + 1)
    curves = tuple(curve(name, number, 100.0 * (np.array(row) / exact - 1.0), "dots") for name, row in rows.items())
    return [Panel("Natural frequencies against 23 nodes, consistent mass", "frequency number", "error (%)", curves)]


def mode_panels(found: ModeShapes) -> list[Panel]:
    """Return the shapes of the lowest four pairs of modes along the shaft."""
    return [
        Panel(
            f"Mode shapes at {found.speed:g} rad/s",
            "axial position (m)",
            "displacement in x",
            tuple(
                curve(f"{_frequency(found, k):.1f} rad/s", found.z, _real(found.shapes[k].x))
                for k in range(0, min(SHOWN_MODES, len(found.shapes)), 2)
            ),
        )
    ]


def response_panels(found: UnbalanceResponse) -> list[Panel]:
    """Return amplitudes over the spin speed."""
    curves = tuple(curve(name, found.speeds, 1e3 * place.amplitude) for name, place in found.places.items())
    return [Panel("Response to unbalance", "spin speed (rad/s)", "amplitude (mm)", curves)]


def receptance_panels(found: SensorReceptance) -> list[Panel]:
    """Return the norm of each column of the receptance over the spin speed (5.18)."""
    norms = 1e6 * np.linalg.norm(found.receptance, axis=1)
    curves = tuple(curve(name, found.speeds, norms[:, k]) for k, name in enumerate(found.forces))
    return [Panel("Norm of the columns of R", "spin speed (Hz)", "|R_i| (um/N)", curves)]


def h_panels(found: InverseReceptance) -> list[Panel]:
    """Return the norm of H, exact and interpolated, over the spin speed."""
    exact, between = (1e-6 * np.linalg.norm(h, axis=(1, 2)) for h in (found.h, found.h_interpolated))
    curves = (curve("exact", found.speeds, exact), curve("interpolated", found.speeds, between, "dashed"))
    return [Panel("Norm of H", "spin speed (Hz)", "|H| (N/um)", curves)]


def force_panels(found: IdentificationForce) -> list[Panel]:
    """Return the amplitude of the test force, and how far it moves the journals, over the frequency."""
    columns = found.columns
    moved = {"MB1": columns.response_mb1, "MB2": columns.response_mb2}
    responses = tuple(curve(name, columns.frequencies, 1e3 * response) for name, response in moved.items())
    return [
        Panel("Test force", "frequency (Hz)", "A (N)", (curve("A", columns.frequencies, columns.amplitude),)),
        Panel("Motion by the test force", "frequency (Hz)", "amplitude (mm)", responses),
    ]


def norm_panels(found: SynchronousResponse) -> list[Panel]:
    """Return the norm of the response over the spin speed, the lines of (5.19), and what was identified (5.18)."""
    at = found.at_speeds
    curves = [curve("(5.19)", found.speeds, 1e6 * found.thesis, "dashed")]
    for k in range(0, len(found.forces), 2):
        curves.append(curve(f"model, {found.forces[k]}", found.speeds, 1e6 * found.norm[:, k]))
    for k in range(0, len(found.forces), 2):
        curves.append(curve(f"identified, {found.forces[k]}", at.speeds, 1e6 * at.measured[:, k], "dots"))
    return [Panel("Norm of the columns of R", "spin speed (Hz)", "|R_i| (um/N)", tuple(curves))]


def reduction_panels(found: ModelReduction) -> list[Panel]:
    """Return frequencies and response of the full, the condensed and the 6-node model over the spin speed."""
    frequencies = []
    for name, model in found.models.items():
        speeds = np.tile(np.append(found.speeds, np.nan), len(model.frequencies))
        rows = np.hstack([np.append(row, np.nan) for row in model.frequencies])
        frequencies.append(Curve(name.replace("_", " "), speeds, rows))
    responses = (curve(name.replace("_", " "), found.speeds, 1e3 * m.displacement) for name, m in found.models.items())
    return [
        Panel("Damped natural frequencies", "spin speed (rad/s)", "frequency (rad/s)", tuple(frequencies)),
        Panel("Largest response to 0.5 g m on D1", "spin speed (rad/s)", "amplitude (mm)", tuple(responses)),
    ]


def law_panels(found: ContactLaws) -> list[Panel]:
    """Return force over penetration of each contact law in one blow."""
    curves = (
        curve(f"{name.replace('_', ' ')} ({loop.equation})", 1e6 * loop.penetration, 1e-3 * loop.force)
        for name, loop in found.laws.items()
    )
    return [Panel("Contact laws in one blow", "penetration (um)", "force (kN)", tuple(curves))]


def _real(shape: Any) -> Any:
    """Return a complex shape turned so that its largest displacement is real and positive."""
    largest = shape[int(np.argmax(np.abs(shape)))]
    return np.real(shape * np.conj(largest)) / abs(largest)


def _frequency(found: ModeShapes, k: int) -> float:
    return float(found.frequencies.speeds[found.speed].frequencies[k])


PANELS: dict[type[Any], Callable[[Any], list[Panel]]] = {
    CampbellDiagram: campbell_panels,
    ThesisTables: frequency_panels,
    ModeShapes: mode_panels,
    UnbalanceResponse: response_panels,
    SensorReceptance: receptance_panels,
    InverseReceptance: h_panels,
    IdentificationForce: force_panels,
    SynchronousResponse: norm_panels,
    ModelReduction: reduction_panels,
    ContactLaws: law_panels,
}
