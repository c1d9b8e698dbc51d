"""Runs of the convergence study: a scenario with other rotor models, substeps, communication steps and starts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.contact_forces import largest_averaged_force, peak_force, received_impulse
from amb_cosim.results.contact_history import peak, touchable
from amb_cosim.results.signal_arrays import cycles
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_cosim.scenario.simulation import execute
from rotor_analysis.reduced_rotor import elastic_shapes, with_modes
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import RotorSource, Tables, load_rotor
from rotor_analysis.shaft import MassModel

ROTORS = ("modes", "mesh")  # what varies in cases with another rotor
START = 1e-6  # relative change of the clearances from one start to the next
SUBSTEP = f"{PLANT}.solver.max_substep"
ACCURACIES = {"diagonal": (1e-2, 1e-3), "consistent": (1e-2, 1e-3, 1e-4)}  # of meshes, by mass matrix
MOST_NODES = 200
STEP_PARTS = (2, 5)  # of a communication step
MESH_MODES = 12  # for which a rotor is meshed whose file does not state a number


@dataclass(frozen=True)
class ConvergenceCase:
    """A run of a scenario, some of whose values are replaced by `settings`.

    varied, label, value
        What differs from the scenario (`modes`, `mesh`, `substep` or `step`; `scenario` if nothing does), the label of
        the run, and a number by which runs are sorted.
    substep
        Factor by which the scenario's longest substep is multiplied. In runs with another rotor model, the longest
        substep before multiplication does not exceed the start value for that model.
    step
        Factor by which the communication step is multiplied.
    start
        Number of the perturbed start; clearances are multiplied by 1 + `start` times `START`.
    """

    scenario: Scenario
    settings: Mapping[str, Raw] = field(default_factory=dict)
    options: RunOptions = DEFAULTS
    varied: str = "scenario"
    label: str = "scenario"
    value: float = 1.0
    substep: float = 1.0
    step: float = 1.0
    start: int = 0


@dataclass(frozen=True)
class Contact:
    """Contact at one site during a run.

    peak_force
        Largest normal force (N), including forces within steps but not impact impulses.
    mean_force
        Largest average of the normal force over `contact_forces.WINDOW`, including impacts (N).
    peak_impulse, impulse
        Largest normal impulse (N s) of the impacts within a step, and total impulse (N s) of impacts and forces over
        the run.
    """

    peak_force: float
    mean_force: float
    peak_impulse: float
    impulse: float


@dataclass(frozen=True)
class CaseResult:
    """Contact at each touched site, outcome, and relative energy balance.

    failure
        Reason for an early end of the run; otherwise empty.
    """

    sites: dict[str, Contact]
    recovery: str | None
    energy_balance: float | None
    failure: str = ""


def varied_cases(base: ConvergenceCase) -> Iterator[ConvergenceCase]:
    """Yield the runs that differ from `base` in the modes, the mesh, the substep or the communication step."""
    rotor = load_rotor(base.scenario.rotor)
    shapes, all_shapes = elastic_shapes(rotor)
    if rotor.reduction.method != "none":
        for modes in (shapes // 2, min(2 * shapes, all_shapes)):
            reduced = with_modes(rotor, modes)
            count, _ = elastic_shapes(reduced)  # with residual shapes, of which a rotor of few modes has more
            if count != shapes or rotor.reduction.method != "free_modes":
                yield _with(reduced, base, varied="modes", label=f"{count} shapes", value=count)
    mass_matrix = rotor.shaft.mass_matrix
    other: MassModel = "consistent" if mass_matrix == "diagonal" else "diagonal"
    mesh_modes, seen = MESH_MODES if rotor.mesh is None else rotor.mesh.modes, {(len(rotor.shaft.nodes), mass_matrix)}
    for mass, accuracy in (*((mass_matrix, accuracy) for accuracy in ACCURACIES[mass_matrix]), (other, None)):
        mesh = {} if accuracy is None else {"mesh": {"modes": mesh_modes, "accuracy": accuracy}}
        meshed = _meshed(base.scenario.rotor, {"shaft": {"mass_matrix": mass}, **mesh}, shapes + 2)
        nodes = len(meshed.shaft.nodes) if meshed else 0
        if meshed and (nodes, mass) not in seen:
            seen.add((nodes, mass))
            yield _with(meshed, base, varied="mesh", label=f"{nodes} nodes, {mass}", value=nodes)
    for parts in (2, 4):
        yield replace(base, varied="substep", label=f"substep / {parts}", value=parts, substep=1.0 / parts)
    for parts in STEP_PARTS:
        yield replace(base, varied="step", label=f"step / {parts}", value=parts, step=1.0 / parts)


def _with(rotor: Rotor, base: ConvergenceCase, **changes: Any) -> ConvergenceCase:
    return replace(base, scenario=base.scenario.model_copy(update={"rotor": rotor}), **changes)


def _meshed(source: RotorSource, tables: Tables, coordinates: int) -> Rotor | None:
    """Return a rotor on another mesh; None if it has too few nodes for the coordinates, or more than `MOST_NODES`."""
    try:
        rotor = load_rotor(source, tables)
    except ValueError:  # the mesh cannot be that fine
        return None
    return rotor if coordinates <= 2 * len(rotor.shaft.nodes) <= 2 * MOST_NODES else None


def prepare_case(case: ConvergenceCase) -> ScenarioPlan:
    """Return the prepared run of a case."""
    scenario = case.scenario
    prepared = prepare_run(scenario, case.settings, options=case.options)
    if case.step != 1.0:
        scenario = scenario.model_copy(update={"communication_step": case.step * prepared.step_size})
    interface = prepared.interfaces[PLANT]
    values = prepared.all_parameters()[PLANT]
    longest = values["solver.max_substep"] or 0.0
    if case.varied in ROTORS:
        longest = min(longest, interface.ports["solver.max_substep"].start or longest)
    changed: dict[str, Raw] = {SUBSTEP: case.substep * longest}
    if case.start:
        for name, value in values.items():
            if name.endswith(".clearance"):
                changed[f"{PLANT}.{name}"] = (value or 0.0) * (1.0 + case.start * START)
    return prepare_run(scenario, {**case.settings, **changed}, options=case.options)


def simulate_case(case: ConvergenceCase) -> CaseResult:
    """Simulate a case; if the run does not reach its end, the result contains the reason."""
    result = execute(prepare_case(case))
    failure = result.outcome.failure
    if failure is not None:
        return CaseResult({}, None, None, failure)
    signals, summary = result.signals, result.summary
    sites = {site: contact for site in touchable(signals) if (contact := _contact(signals, site)) is not None}
    return CaseResult(sites, summary.recovery, summary.energy_balance)


def _contact(signals: Signals, site: str) -> Contact | None:
    """Return the contact at a site from cycle 0 on; None if it was not recorded."""
    largest, averaged = peak_force(signals, site), largest_averaged_force(signals, site)
    received, impact = received_impulse(signals, site), peak(signals, f"{site}.impulse")
    if largest is None or averaged is None or received is None or impact is None:
        return None
    before = np.interp(0.0, cycles(signals), received)
    return Contact(largest, averaged, impact, float(received[-1] - before))
