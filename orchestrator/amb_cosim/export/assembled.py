"""Systems in one FMU: the levitated rotor, or any system of models, with a scenario's start values.

FMPy's container cannot hold such a system. The container only makes steps that are multiples of one fixed step, so it
cannot divide a step at the samples and sum over the parts. It also cannot save its state, so a step cannot be repeated.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.building.build_target import BuildTarget
from amb_cosim.cosim.choices import Flavour, Fmi
from amb_cosim.cosim.fmu.fmus import build_models
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.export.models import Made
from amb_cosim.export.planned import plan_models
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.rotors import RotorSource, TableSource
from amb_cosim.scenario.scenario import Scenario
from amb_files.checks import as_path

NAME = "levitated_rotor"
DESCRIPTION = (
    "Flexible rotor levitated by magnetic bearings under sampled control: rotor_contact, amb_actuator and "
    "rolac_controller in one FMU"
)
SYSTEM = "levitated"  # the default system
IN_ORDER = (CONTROLLER, ACTUATOR, PLANT)  # models of its components, in order of their steps


def build_assembled(
    folder: str | Path,
    scenario: str | Path | Scenario | None = None,
    flavour: Flavour = "native",
    rotor: RotorSource = None,
    receptances: TableSource = None,
    platforms: str | Iterable[str] | None = None,
    fmi: Fmi = 2,
    arrays: bool = True,
    sources: bool = False,
) -> Path:
    """Write an FMU with all components of a system into a folder and return its path.

    The FMU is called `levitated_rotor` if it contains a controller, an actuator and a rotor; otherwise it has the name
    of the system.

    Parameters
    ----------
    scenario
        Source of the system, the rotor, and the start values of parameters and inputs: a `Scenario`, the name or TOML
        file of a scenario, or a system file. The default is the system `levitated`.
    rotor, receptances
        Values that replace those of the scenario; see `build`.
    folder, flavour, platforms, fmi, arrays, sources
        As for `build`.

    Raises
    ------
    ValueError
        If the scenario or a file is invalid, a component of the system is not a model, the coupling of the system is
        iterative, or the FMU cannot be built.

    Examples
    --------
    >>> build_assembled("fmus", "compressor_levitated").name
    'levitated_rotor.fmu'
    """
    options = {"scenario": scenario, "rotor": rotor, "receptances": receptances}
    target = BuildTarget(flavour, platforms, fmi, arrays, sources)
    return build_models((NAME,), as_path("folder", folder), target, **options)[0]


def levitated_rotor(
    scenario: str | Path | Scenario | None = None,
    rotor: RotorSource = None,
    receptances: TableSource = None,
    **_: Any,
) -> Made:
    """Return the assembled model and its constants; see `build_assembled` for the arguments and errors."""
    from fmi_export.model import with_starts

    prepared = plan_models(SYSTEM if scenario is None else scenario, rotor, receptances)
    plan = prepared.plan
    model, constants = assembled(plan, prepared.made)
    starts = {f"{c}.{name}": value for c, parameters in plan.parameters.items() for name, value in parameters.items()}
    return with_starts(model, starts | dict(plan.inputs)), constants


def assembled(plan: Plan, made: Mapping[str, Made]) -> Made:
    """Return the model of a planned system, with the models in `made` as its components, and the model's constants.

    If exactly one component has a sample time, steps are split at its samples. Otherwise, they are split into
    communication steps.

    Raises
    ------
    ValueError
        If the coupling is iterative.
    """
    from fmi_export.model import AssembledModel
    from levitated_rotor.assembly import Composite
    from levitated_rotor.model import model_for

    system = plan.system
    coupling = system.coupling
    if coupling == "iterative":
        raise ValueError("coupling = 'iterative' is not allowed in an assembly; it must be 'gauss_seidel' or 'jacobi'")
    composite = Composite(
        tuple(AssembledModel(c.name, *made[c.name], c.every) for c in system.components),
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
