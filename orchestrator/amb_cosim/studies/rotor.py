"""Studies of a rotor: what `amb-cosim study NAME` computes, prints and writes. Each takes a rotor and its options."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from amb_cosim.cosim.values import quantity
from amb_cosim.studies import figures, modal
from amb_cosim.studies.outcome import Outcome
from amb_cosim.studies.tables import as_text as tables_as_text
from amb_cosim.studies.tables import rotor_tables
from amb_cosim.text_tables import labelled_table
from fmi_export.model import Array
from rotor_analysis.assembly import MassModel
from rotor_analysis.campbell import Campbell
from rotor_analysis.campbell import campbell as follow_modes
from rotor_analysis.condensation import condensation_error
from rotor_analysis.modes import modes as modes_of
from rotor_analysis.modes import translations
from rotor_analysis.response import orbit
from rotor_analysis.response import unbalance_response as unbalance_response_of
from rotor_analysis.rotor import Rotor, require
from rotor_analysis.supported import supported

POINTS = 161  # of a range of speeds


def campbell(rotor: Rotor, mass: MassModel, up_to: str, count: int) -> Outcome:
    """Damped frequencies and damping ratios over speed, and the critical speeds (Figs 3.1, 3.6)."""
    diagram = follow_modes(supported(rotor, mass).model, _speeds(up_to), count)
    data = {
        "rotor": rotor.name,
        "mass": mass,
        "speeds_rad_s": diagram.speeds.tolist(),
        "modes": [
            {
                "frequencies_rad_s": _listed(frequencies),
                "damping_ratios": _listed(ratios),
                "whirl": [mode.whirl if mode else None for mode in track],
            }
            for frequencies, ratios, track in zip(
                diagram.frequencies, diagram.damping_ratios, diagram.tracks, strict=True
            )
        ],
        "critical_speeds": [
            {"speed_rad_s": c.Omega, "mode": c.number, "damping_ratio": c.damping_ratio, "whirl": c.whirl}
            for c in diagram.critical_speeds
        ],
    }
    figure = partial(figures.campbell, rotor.name, diagram)
    return Outcome(data, {"campbell": figure}, [_critical_speeds(diagram)])


def modes(rotor: Rotor, mass: MassModel, speed: str, count: int) -> Outcome:
    """Mode shapes with the orbits of their nodes (Figs 3.2, 3.3)."""
    Omega = modal.speed(speed)
    model = supported(rotor, mass).model
    found = modes_of(model, Omega, count)
    data = modal.modes_at(rotor, mass, [Omega], count)
    listed = modal.as_text(data)
    data["shapes"] = [
        {
            "x": [[value.real, value.imag] for value in translations(model, mode.shape)[:, 0].tolist()],
            "y": [[value.real, value.imag] for value in translations(model, mode.shape)[:, 1].tolist()],
        }
        for mode in found
    ]
    data["z_m"] = list(rotor.shaft.nodes)
    return Outcome(data, {"modes": partial(figures.mode_shapes, rotor, Omega, found)}, listed)


def tables(rotor: Rotor, up_to: str, planes: str | None) -> Outcome:
    """Frequencies by mesh and mass matrix, full against condensed, and the errors (Tables 3.1 to 3.4)."""
    chosen = modal.node_list(planes, "planes") if planes else rotor.planes.master
    error = condensation_error(rotor, _speeds(up_to), chosen) if chosen else None
    data = {"rotor": rotor.name, **rotor_tables(rotor)}
    if error is not None:
        data["condensation"] = {
            "planes": list(error.planes),
            "speeds_rad_s": error.speeds.tolist(),
            "frequency_error_percent": [_listed(row) for row in error.frequency.T],
            "eigenvalue_error_percent": [_listed(row) for row in error.eigenvalue.T],
        }
    return Outcome(data, {"tables": partial(figures.errors, data, error)}, tables_as_text(data))


def unbalance_response(
    rotor: Rotor, mass: MassModel, up_to: str, unbalance: str, node: int | None, clearance: str
) -> Outcome:
    """Amplitude and phase at the bearings and the shaft ends over speed, unbalance on one node (Fig. 3.7)."""
    u, limit = quantity(unbalance, "kg.m", "unbalance"), quantity(clearance, "m", "clearance")
    require(0.0 < u < np.inf, "unbalance", f"{u:g} kg m", "> 0 kg m")
    require(0.0 < limit < np.inf, "clearance", f"{limit:g} m", "> 0 m")
    at = _first_disc(rotor) if node is None else node
    places = _places(rotor)
    speeds = _speeds(up_to, points=4 * POINTS)[1:]
    seen = tuple(places.values())
    amplitude, _, phase = orbit(unbalance_response_of(supported(rotor, mass), {at: u}, speeds, seen))
    lag = np.unwrap(phase, axis=0)
    data: dict[str, Any] = {
        "rotor": rotor.name,
        "mass": mass,
        "unbalance_kg_m": u,
        "node": at,
        "speeds_rad_s": speeds.tolist(),
        "places": {
            name: {"node": place, "amplitude_m": amplitude[:, k].tolist(), "phase_rad": lag[:, k].tolist()}
            for k, (name, place) in enumerate(places.items())
        },
    }
    figure = partial(figures.unbalance_response, rotor.name, data, limit)
    return Outcome(data, {"unbalance_response": figure}, [_peaks(data, limit)])


def _speeds(up_to: str, points: int = POINTS) -> Array:
    highest = modal.speed(up_to, "up-to")
    require(highest > 0.0, "up-to", f"{highest:g} rad/s", "> 0 rad/s")
    return np.linspace(0.0, highest, points)


def _listed(values: Array) -> list[float | None]:
    """For JSON, which knows no NaN."""
    return [None if np.isnan(value) else float(value) for value in values]


def _first_disc(rotor: Rotor) -> int:
    nodes = (*rotor.planes.discs, *(body.node for body in rotor.bodies))
    if not nodes:
        raise ValueError("node is missing: a rotor without disc planes and bodies does not say where its unbalance is")
    return nodes[0]


def _places(rotor: Rotor) -> dict[str, int]:
    """The bearings and the shaft ends, by name."""
    z, bearings = rotor.shaft.nodes, {bearing.name: bearing.node for bearing in rotor.bearings}
    ends = {f"end at z = {z[node - 1]:.4g} m": node for node in (1, len(z)) if node not in bearings.values()}
    return bearings | ends


def _critical_speeds(diagram: Campbell) -> Table:
    table = Table(title="Critical speeds", title_justify="left", box=None, padding=(0, 2, 0, 0))
    for heading in ("(rad/s)", "(Hz)", "mode", "damping ratio"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("whirl", no_wrap=True)
    for c in diagram.critical_speeds:
        table.add_row(
            f"{c.Omega:.3f}", f"{c.Omega / (2 * np.pi):.3f}", str(c.number), f"{c.damping_ratio:.4f}", c.whirl
        )
    return table


def _peaks(data: dict[str, Any], limit: float) -> Table:
    table = labelled_table("Largest amplitude", "place", "(mm)", "of the clearance", "at (rad/s)")
    for name, place in data["places"].items():
        top = int(np.argmax(place["amplitude_m"]))
        peak = place["amplitude_m"][top]
        table.add_row(name, f"{1e3 * peak:.4f}", f"{peak / limit:.3f}", f"{data['speeds_rad_s'][top]:.1f}")
    return table
