"""Study of the steady response of a rotor or a levitated machine to unbalance, over the spin speed."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from amb_analysis.machine.machine import Machine, machine_of
from amb_analysis.machine.response import refined_response
from amb_analysis.studies.coefficient_limits import Limits, is_extrapolated, limits_of
from amb_analysis.studies.inputs import (
    DEFAULT_RANGE,
    GRADE,
    Number,
    controlled,
    node_numbers,
    positive,
    reach_of,
    speed_range,
    spin_speed,
)
from amb_analysis.studies.unbalance_records import CriticalResponse, PlacedUnbalance, PlaceResponse, UnbalanceResponse
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.fmu.fmus import FmuSource
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.component_names import ACTUATOR
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_files.checks import require_choice
from amb_files.suggestions import suggest
from array_types import Array, Complex
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.parts import Point, table_speeds
from rotor_analysis.peaks import highest_peaks, separation_margin
from rotor_analysis.refinement import about_resonances, refined, with_samples
from rotor_analysis.resonances import resonances
from rotor_analysis.response import dynamic_stiffness, orbit
from rotor_analysis.response import unbalance_response as steady_response
from rotor_analysis.rigid_body import floating_motions
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, load_rotor
from rotor_analysis.shaft import MASS_MODELS, MassModel
from rotor_analysis.supported_rotor import supported_rotor

POINTS = 644  # speeds of the curves of a rotor alone, with speed 0, which is left out
COARSE = 10  # speeds per interval of the search for critical speeds
LEVITATED = 161  # speeds of the curves of a levitated machine, with speed 0, before its peaks are refined
REACH = 2.0  # highest speed of a response, over that of the scenario


def unbalance_response(
    rotor: RotorSource = None,
    *,
    scenario: str | Path | Scenario | None = None,
    controller: FmuSource | PathLike[str] | None = None,
    mass: MassModel | None = None,
    up_to: Number | None = None,
    unbalance: Number | None = None,
    place: str | None = None,
    node: int | None = None,
    clearance: Number | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> UnbalanceResponse:
    """Return the unbalance response over the spin speed: amplitude and phase at bearings, contact sites and ends.

    [-Omega^2 M + i Omega (C + Omega G) + K - F(i Omega)] Q = Omega^2 (u, -i u)

    F describes the forces of a scenario's magnetic bearings, with controller, hold, delay and amplifiers
    (`machine.response`); for a rotor alone, F is 0. The speeds are denser near critical speeds and near all maxima
    (`rotor_analysis.refinement`), so that critical speeds and maxima are accurate to 0.1 % for any `up_to`.

    Parameters
    ----------
    rotor
        A rotor or a rotor file; by default the rotor of the scenario, or the packs' default rotor.
    scenario, controller
        Scenario of a machine whose magnetic bearings levitate the rotor, and a controller that replaces the machine's
        own.
    mass
        Mass matrix of a rotor alone, `diagonal` or `consistent`; by default that of the rotor file.
    up_to
        Highest spin speed (rad/s), or a string with its unit. For a machine, the default is twice the scenario's speed,
        or less if the loop becomes unstable below that. For a rotor alone, or a scenario at rest, the default is the
        highest speed that the rotor file states (`[reduction] speed`), or else 6000 rpm.
    unbalance
        Unbalance (kg m), or a string with its unit. By default, the machine has all unbalances that are present at the
        end of the scenario. If there is no scenario, or it has no unbalance, the default is the residual unbalance of
        grade G 2.5. The speed for this grade is that of the scenario or, for a rotor alone, the highest speed of the
        rotor file, or else 6000 rpm.
    place, node
        Part that carries the unbalance, or the number of its node in the rotor file; by default the first disc.
    clearance
        Radial clearance (m), or a string with its unit, with which all amplitudes are compared; by default the
        clearance of the site at each place.
    set, flavour
        Values of the scenario's parameters by `component.variable`, and the flavour of the FMUs.

    Raises
    ------
    ValueError
        If a file cannot be read, an argument is out of range, the scenario has no magnetic bearings, or the loop is not
        stable at one of the speeds.

    Examples
    --------
    >>> response = unbalance_response("compressor", unbalance="1 g.m", place="impeller1")
    >>> [(item.place, f"{item.speed:.0f} rad/s") for item in response.critical_speeds]
    [('seal', '454 rad/s'), ('end at z = 0 m', '970 rad/s')]
    """
    require_choice("flavour", flavour, FLAVOURS)
    if mass is not None:
        require_choice("mass", mass, MASS_MODELS)
    clearance_of_all = None if clearance is None else positive(clearance, "m", "clearance")
    amount = None if unbalance is None else positive(unbalance, "kg.m", "unbalance")
    if scenario is not None:
        if mass is not None:
            raise ValueError(f"mass = {mass} is not allowed with a scenario; set it in the rotor file")
        values = controlled(scenario, rotor, controller)
        machine = machine_of(prepare_run(values, set, options=RunOptions(flavour=flavour)), ACTUATOR)
        return _of_machine(
            machine, values.name, *_loads(machine, values.rotor, amount, place, node), up_to, clearance_of_all
        )
    if controller is not None or set:
        raise ValueError("a controller or settings require a scenario; name one")
    description = load_rotor(rotor)
    mass = mass or description.shaft.mass_matrix
    unplaced = node is None and place is None
    loaded = _first_disc(description) if unplaced else _point(description, rotor, place, node)
    places = _places(description)
    speeds_of_tables = table_speeds((*description.bearings, *description.seals))
    speeds = with_samples(speed_range(up_to or reach_of(description), POINTS)[1:], speeds_of_tables)
    at_highest = description.mass * GRADE / spin_speed(reach_of(description))
    load = {loaded: complex(at_highest if amount is None else amount)}
    coarse = np.unique([*speeds[::COARSE], speeds[-1]])
    rotor_model, nodes = supported_rotor(description, mass), tuple(places.values())
    critical = resonances(partial(dynamic_stiffness, rotor_model.model), with_samples(coarse, speeds_of_tables))
    speeds, response = refined(
        lambda more: steady_response(rotor_model, load, more, nodes),
        about_resonances(speeds, critical),
        lambda motion: orbit(motion)[0],
    )
    curves = _curves(description, places, response, clearance_of_all)
    limits = limits_of((*description.bearings, *description.seals))
    peaks = _peaks(speeds, curves, limits, None)
    return UnbalanceResponse(
        description.name,
        mass,
        None,
        None,
        *_largest(description, load, _named(description, load)),
        speeds,
        curves,
        peaks,
        limits,
        floating=floating_motions(description, speeds[::COARSE]),
        warnings=implausible_sizes(description),
    )


def _of_machine(
    machine: Machine,
    name: str,
    loads: Mapping[Point, complex],
    placed: Mapping[str, complex],
    up_to: Number | None,
    clearance_of_all: float | None,
) -> UnbalanceResponse:
    rotor, places, Omega = machine.rotor, _places(machine.rotor), machine.Omega or None
    highest = up_to or (DEFAULT_RANGE if Omega is None else REACH * Omega)
    swept = with_samples(speed_range(highest, LEVITATED)[1:], machine.table_speeds)
    reach = len(swept)
    if up_to is None:
        swept = _stable(machine, swept)
    machine.loop.check_stable(swept)
    stable_up_to = float(swept[-1]) if len(swept) < reach else None
    speeds, response = refined_response(machine, swept, [loads], tuple(places.values()))
    motion = response[:, 0, [node - 1 for node in places.values()]]
    curves = _curves(rotor, places, motion, clearance_of_all)
    clearances: dict[int, float] = {}
    for place in machine.clearances.values():
        clearances[place.node] = min(place.reach, clearances.get(place.node, place.reach))
    if clearance_of_all is None:
        curves = {k: replace(c, clearance=clearances.get(c.node)) for k, c in curves.items()}
    limits = limits_of(rotor.seals)
    criticals = _peaks(speeds, curves, limits, Omega)
    return UnbalanceResponse(
        rotor.name,
        rotor.shaft.mass_matrix,
        name,
        Omega,
        *_largest(rotor, loads, placed),
        speeds,
        curves,
        criticals,
        limits,
        stable_up_to,
        warnings=machine.prepared.warnings,
    )


def _stable(machine: Machine, speeds: Array) -> Array:
    """Return the speeds below the lowest unstable speed; only speeds above the operating speed are checked."""
    for k, Omega in enumerate(map(float, speeds)):
        if Omega > machine.Omega and not machine.loop.poles(Omega).stability.is_stable:
            return speeds[: max(k, 1)]
    return speeds


def _loads(
    machine: Machine, source: RotorSource, amount: float | None, place: str | None, node: int | None
) -> tuple[dict[Point, complex], dict[str, complex]]:
    """Return unbalances (kg m) by point and by place: all unbalances of the scenario, or one unbalance at one point."""
    planned = machine.unbalanced_points
    if amount is None and place is None and node is None and planned:
        return planned, {name: u for name, u in machine.unbalance.items() if u}
    if place is not None or node is not None:
        at = _point(machine.rotor, source, place, node)
    else:
        at = max(planned, key=lambda number: abs(planned[number])) if planned else _first_disc(machine.rotor)
    if amount is None:
        if at not in planned and not machine.Omega:
            raise ValueError(
                "unbalance is missing: the scenario has none, and a balancing grade does not define one at rest"
            )
        amount = abs(planned[at]) if at in planned else machine.rotor.mass * GRADE / machine.Omega
    load = {at: complex(amount)}
    return load, _named(machine.rotor, load)


def _point(rotor: Rotor, source: RotorSource, place: str | None, node: int | None) -> Point:
    """Return the point at which unbalance of a part acts, or the node that has this number in the rotor file."""
    if place is not None and node is not None:
        raise ValueError(f"place = {place} is not allowed with node = {node}; set only one of them")
    parts = rotor.nodes_by_name
    if place is not None and place not in parts:
        raise ValueError(f"place = {place} is not allowed; {suggest(place, parts)}")
    if place is not None:
        return rotor.point_of(place)
    assert node is not None
    return node_numbers(node, "node", rotor, source)[0]


def _named(rotor: Rotor, loads: Mapping[Point, complex]) -> dict[str, complex]:
    """Return unbalances (kg m) by the name of a part at each point, or by the point's position if no part is there."""
    names = {rotor.point_of(name): name for name in reversed(rotor.nodes_by_name)}
    return {names.get(point, f"z = {rotor.position_of(point):.4g} m"): u for point, u in loads.items()}


def _largest(
    rotor: Rotor, loads: Mapping[Point, complex], placed: Mapping[str, complex]
) -> tuple[float, float, dict[str, PlacedUnbalance]]:
    """Return the largest unbalance of any point (kg m), that point's position (m), and the unbalances of the places."""
    largest = max(loads, key=lambda point: abs(loads[point]))
    unbalances = {place: PlacedUnbalance(abs(u), math.degrees(cmath.phase(u))) for place, u in placed.items()}
    return abs(loads[largest]), rotor.position_of(largest), unbalances


def _curves(
    rotor: Rotor, places: Mapping[str, int], response: Complex, clearance_of_all: float | None
) -> dict[str, PlaceResponse]:
    """Return the response at each place from the displacements of all places (m), shape (speeds, places, 2)."""
    amplitude, minor, phase = orbit(response)
    continuous, z = np.unwrap(phase, axis=0), rotor.shaft.nodes
    return {
        name: PlaceResponse(
            node,
            z[node - 1],
            clearance_of_all or _clearance(rotor, node),
            amplitude[:, k],
            continuous[:, k],
            minor[:, k],
        )
        for k, (name, node) in enumerate(places.items())
    }


def _peaks(
    speeds: Array, places: Mapping[str, PlaceResponse], limits: Limits, operating: float | None
) -> tuple[CriticalResponse, ...]:
    """Return the peaks; if several lie within half the half-power width, only the highest is kept."""
    peaks = highest_peaks(speeds, {name: place.amplitude for name, place in places.items()})
    return tuple(
        CriticalResponse(
            name,
            peak.Omega,
            peak.amplitude,
            peak.amplification,
            None if not operating else separation_margin(peak.Omega, operating, operating),
            is_extrapolated(limits, peak.Omega),
        )
        for name, peak in peaks
    )


def _first_disc(rotor: Rotor) -> Point:
    """Return the point of the first disc plane or, if there is none, of the first body."""
    names = [body.name for body in (*rotor.discs, *rotor.bodies)]
    if not names:
        raise ValueError("node is missing: a rotor without disc planes or bodies has no default place of unbalance")
    return rotor.point_of(names[0])


def _places(rotor: Rotor) -> dict[str, int]:
    """Return the nodes of bearings, sites and shaft ends, by name; each node occurs once."""
    z = rotor.shaft.nodes
    ends = (SimpleNamespace(name=f"end at z = {z[node - 1]:.4g} m", node=node) for node in (1, len(z)))
    parts: tuple[Any, ...] = (*rotor.bearings, *rotor.sites, *ends)
    first = {part.node: part.name for part in reversed(parts)}
    return {name: node for node, name in sorted(first.items())}


def _clearance(rotor: Rotor, node: int) -> float | None:
    """Return the smallest clearance (m) of the sites at a node; None if there is no site at the node."""
    return min((site.clearance for site in rotor.sites if site.node == node), default=None)
