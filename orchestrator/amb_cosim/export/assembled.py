"""Systems as one FMU: the levitated rotor, or any other whose components are models, with a scenario's start values."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.basics.build_target import BuildTarget
from amb_cosim.cosim.basics.choices import Coupling, Flavour, Fmi
from amb_cosim.cosim.fmu.fmus import build_models
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.export.models import Made
from amb_cosim.export.planned import plan_models
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.scenario import Scenario

NAME = "levitated_rotor"
DESCRIPTION = (
    "Flexible rotor levitated by magnetic bearings under sampled control, in one: rotor_contact, amb_actuator and "
    "rolac_controller"
)
SYSTEM = "levitated"  # what is assembled without a scenario
IN_ORDER = (CONTROLLER, ACTUATOR, PLANT)  # models of the components of what is called so, as they step


def build_assembled(
    folder: str | Path,
    scenario: str | Path | Scenario | None = None,
    flavour: Flavour = "native",
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    platforms: Iterable[str] | None = None,
    fmi: Fmi = 2,
    arrays: bool = True,
    sources: bool = False,
) -> Path:
    """Write one FMU with all components of a system into a folder and return its path.

    It is `levitated_rotor` where these are controller, actuator and rotor, and called like the system otherwise.

    Parameters
    ----------
    scenario
        Whose system is assembled, of whose rotor, and whose parameters and first inputs are the start values: a
        `Scenario`, a name or the path of a TOML file; the path of a system file; the system `levitated` by default.
    rotor, receptances
        In place of the scenario's; see `build`.
    folder, flavour, platforms, fmi, arrays, sources
        As for `build`.

    Raises
    ------
    ValueError
        If the scenario or a file is wrong, a component of the system is no model, its coupling is iterative, or the FMU
        cannot be built.
    """
    options = {"scenario": scenario, "rotor": rotor, "receptances": receptances}
    target = BuildTarget(flavour, platforms, fmi, arrays, sources)
    return build_models((NAME,), Path(folder), target, **options)[0]


def levitated_rotor(
    scenario: str | Path | Scenario | None = None,
    rotor: str | Path | None = None,
    receptances: str | Path | None = None,
    **_: Any,
) -> Made:
    """Return the assembled model and its constants; see `build_assembled` for the arguments and errors."""
    from fmi_export.model import with_starts

    planned = plan_models(SYSTEM if scenario is None else scenario, rotor, receptances)
    plan = planned.plan
    model, constants = assembled(plan, planned.made, planned.coupling)
    starts = {f"{component}.{name}": value for component, of in plan.parameters.items() for name, value in of.items()}
    return with_starts(model, starts | dict(plan.inputs)), constants


def assembled(plan: Plan, made: Mapping[str, Made], coupling: Coupling | None = None) -> Made:
    """Return the model of a planned system whose components are these models, and its constants.

    Steps are cut at the samples of the one component that has a sample time, else at the communication step.

    Parameters
    ----------
    coupling
        In place of the system's.

    Raises
    ------
    ValueError
        If the coupling is iterative.
    """
    from fmi_export.model import AssemblyPart
    from levitated_rotor.assembly import Composite
    from levitated_rotor.model import model_for

    system = plan.system
    coupling = coupling or system.coupling
    if coupling == "iterative":
        raise ValueError("coupling = 'iterative' is not allowed in an assembly; it must be 'gauss_seidel' or 'jacobi'")
    composite = Composite(
        tuple(AssemblyPart(c.name, *made[c.name], c.every) for c in system.components),
        {link.target: link.source for link in system.connections},
        {signal.name: signal.targets for signal in system.signals},
        plan.step_size,
        coupling == "jacobi",
    )
    constants = np.concatenate([part.constants for part in composite.parts])
    if tuple(c.fmu for c in system.components) == IN_ORDER and coupling == "gauss_seidel":
        return model_for(composite, NAME, DESCRIPTION), constants
    name = re.sub(r"\W", "_", system.name, flags=re.ASCII)
    description = system.description or f"System {system.name}"
    return model_for(composite, f"_{name}" if name[0].isdigit() else name, description), constants
