"""Runs of the study of convergence: one scenario with other descriptions of its rotor, substeps and starts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.contact_forces import largest_averaged_force, peak_force, received_impulse
from amb_cosim.results.contact_history import peak, touchable
from amb_cosim.results.places import PLANT
from amb_cosim.results.series import cycles
from amb_cosim.scenario.scenario import Scenario
from amb_cosim.scenario.simulation import PlannedRun, prepare, run_prepared
from amb_files.toml import read_toml
from rotor_analysis.assembly import assemble
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import MassModel

START = 1e-6  # relative change of the clearances from one start to the next
SUBSTEP = f"{PLANT}.solver.max_substep"
ACCURACIES = {"diagonal": (1e-2, 1e-3), "consistent": (1e-2, 1e-3, 1e-4)}  # of meshes, by mass matrix
MOST_NODES = 200
STEP_PARTS = (2, 5)  # of a communication step
MESH_MODES = 12  # of a rotor that does not say how many modes its mesh is for


@dataclass(frozen=True)
class ConvergenceCase:
    """One run.

    varied, label, value
        What differs from the scenario: nothing for `scenario`, else `modes`, `mesh`, `substep` or `step`; how it is
        printed; its place on an axis.
    rotor
        Rotor file.
    substep
        Factor of the longest substep, which is no longer than the start value for this rotor.
    step
        Factor of the communication step.
    start
        Number of the perturbed start: clearances are larger by `start` times `START`.
    """

    scenario: Scenario
    settings: Mapping[str, Raw]
    flavour: Flavour
    varied: str
    label: str
    value: float
    rotor: str
    substep: float = 1.0
    step: float = 1.0
    start: int = 0


@dataclass(frozen=True)
class Contact:
    """Contact at a site over a run.

    peak_force
        Largest normal force (N), within steps too, without the impulses of impacts.
    mean_force
        Largest normal force averaged over `contact_forces.WINDOW`, impacts included (N).
    peak_impulse, impulse
        Largest normal impulse of the impacts in a step, and the impulse of impacts and forces over the run (N s).
    """

    peak_force: float
    mean_force: float
    peak_impulse: float
    impulse: float


@dataclass(frozen=True)
class CaseResult:
    """Contact at each site that was touched, what the contact led to, and the relative energy balance.

    failure
        Why the run did not reach its end; empty if it did.
    """

    sites: dict[str, Contact]
    recovery: str | None
    energy_balance: float | None
    failure: str = ""


def varied_cases(base: ConvergenceCase, folder: Path) -> Iterator[ConvergenceCase]:
    """Yield the runs with other modes, meshes and substeps than `base`; rotor files are written to `folder`."""
    rotor, data = load_rotor(base.rotor), read_toml(Path(base.rotor), f"rotor file {base.rotor}")
    full, reduced = assemble(rotor), reduced_rotor(rotor).model
    planes = len(reduced.translations)
    retained, inner = reduced.size // 2 - planes, full.size // 2 - planes

    def with_rotor(varied: str, label: str, value: float, content: Mapping[str, Any]) -> ConvergenceCase:
        path = folder / f"{label.replace(', ', '_').replace(' ', '_')}.toml"
        path.write_text(tomli_w.dumps(content), encoding="utf-8")
        return replace(base, varied=varied, label=label, value=value, rotor=str(path))

    if rotor.reduction.method != "none":
        values = {key: value for key, value in data.get("reduction", {}).items() if key == "masters"}
        fewer = (retained // 4, retained // 2) if retained else (planes // 2,)
        for modes in sorted({*fewer, min(2 * retained or planes, inner)} - {retained}):
            content = data | {"reduction": values | {"method": "craig_bampton", "modes": modes}}
            yield with_rotor("modes", f"{modes} modes", modes, content)
    local = rotor.shaft.mass_matrix
    other: MassModel = "consistent" if local == "diagonal" else "diagonal"
    mesh_modes, seen = MESH_MODES if rotor.mesh is None else rotor.mesh.modes, {(len(rotor.shaft.nodes), local)}
    for mass, accuracy in (*((local, accuracy) for accuracy in ACCURACIES[local]), (other, None)):
        mesh = {} if accuracy is None else {"mesh": {"modes": mesh_modes, "accuracy": accuracy}}
        content = data | mesh | {"shaft": data["shaft"] | {"mass_matrix": mass}}
        case = with_rotor("mesh", f"mesh {accuracy}, {mass}", 0.0, content)
        nodes = _nodes(case.rotor, retained, planes)
        if nodes is not None and (nodes, mass) not in seen:
            seen.add((nodes, mass))
            yield replace(case, label=f"{nodes} nodes, {mass}", value=nodes)
    for parts in (2, 4):
        yield replace(base, varied="substep", label=f"substep / {parts}", value=parts, substep=1.0 / parts)
    for parts in STEP_PARTS:
        yield replace(base, varied="step", label=f"step / {parts}", value=parts, step=1.0 / parts)


def _nodes(rotor: str, modes: int, planes: int) -> int | None:
    """The number of nodes of a rotor, None if there are too few for its modes and planes, or too many for a run."""
    try:
        nodes = len(load_rotor(rotor).shaft.nodes)
    except ValueError:  # the mesh cannot be that fine
        return None
    return nodes if modes + planes <= 2 * nodes <= 2 * MOST_NODES else None


def rotor_file(scenario: Scenario) -> Path:
    """Return the file of a scenario's rotor."""
    return rotor_path(scenario.rotor)


def prepare_case(case: ConvergenceCase) -> PlannedRun:
    """Return a case that is ready to run."""
    scenario = case.scenario.model_copy(update={"rotor": case.rotor})
    prepared = prepare(scenario, case.settings, flavour=case.flavour)
    if case.step != 1.0:
        scenario = scenario.model_copy(update={"communication_step": case.step * prepared.plan.step_size})
    interface = prepared.interfaces[PLANT]
    values = prepared.plan.all_parameters(prepared.interfaces)[PLANT]
    settings = values["solver.max_substep"] or 0.0
    longest = min(settings, interface.ports["solver.max_substep"].start or settings)
    changed: dict[str, Raw] = {SUBSTEP: case.substep * longest}
    if case.start:
        for name, value in values.items():
            if name.endswith(".clearance"):
                changed[f"{PLANT}.{name}"] = (value or 0.0) * (1.0 + case.start * START)
    return prepare(scenario, {**case.settings, **changed}, flavour=case.flavour)


def simulate_case(case: ConvergenceCase) -> CaseResult:
    """Simulate a case. A run that does not reach its end is a result too: it says why."""
    result = run_prepared(prepare_case(case))
    failure = result.outcome.failure
    if failure is not None:
        return CaseResult({}, None, None, failure)
    signals, summary = result.signals, result.summary
    sites = {site: contact for site in touchable(signals) if (contact := _contact(signals, site)) is not None}
    return CaseResult(sites, summary.recovery, summary.energy_balance)


def _contact(signals: Signals, site: str) -> Contact | None:
    """Contact at a site from cycle 0 on; None where it was not recorded."""
    largest, averaged = peak_force(signals, site), largest_averaged_force(signals, site)
    received, impact = received_impulse(signals, site), peak(signals, f"{site}.impulse")
    if largest is None or averaged is None or received is None or impact is None:
        return None
    before = np.interp(0.0, cycles(signals), received)
    return Contact(largest, averaged, impact, float(received[-1] - before))
