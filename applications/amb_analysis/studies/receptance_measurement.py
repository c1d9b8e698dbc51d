"""Identification of the receptance at one spin speed by the controller FMU, in a co-simulation with the plant.

The run covers the six slots of the identification; at its end, R is read from the controller's outputs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np

from amb_analysis.linear.sampled_loop import parameters_of_loop
from amb_analysis.machine.machine import Machine, machine_of
from amb_analysis.studies.sampled_receptance import inner_response, sampled_receptance
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.run.options import DEFAULTS, Progress, RunOptions
from amb_cosim.cosim.system.values import Raw
from amb_cosim.model_constants.controller_data import MAX_CONDITION, condition_number
from amb_cosim.model_constants.receptance_file import ReceptanceTable, empty_table, loop_parameters, read_table
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER
from amb_cosim.scenario.control_loop import inner_loop_parameters
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario, as_scenario, make_scenario
from amb_cosim.scenario.simulation import execute
from array_types import Complex
from rolac_controller.control_loop import ControlLoop
from rolac_controller.enumerations import ERRORS, GIVEN, ILL_CONDITIONED, last_stages, stages
from rolac_controller.excitation import force_component, periods
from rotor_analysis.rotor_file import RotorSource, load_rotor

if TYPE_CHECKING:
    import xarray as xr


STEP = 250e-6  # s
MARGIN = 2.0  # revolutions: to fill the window before the first slot, and for the last sample of the last slot
LARGE = 0.1  # of the largest element of a column; smaller elements are not compared
NAME = "identification"
RECORDED = ["rolac_controller.r.*", "rolac_controller.identification_*"]


@dataclass(frozen=True, eq=False)
class IdentifiedReceptance:
    """Result of an identification at one speed.

    speed
        Spin speed (rad/s).
    order
        Order of the excited harmonic.
    periods, force
        Number of revolutions in a slot, and amplitude of the test force (N).
    receptance
        R, shape (n_sensors, n_axes), complex (m/N); None if the identification failed.
    model
        R of the linear model of the same sampled loop, for comparison; None if `receptance` itself is from this model.
    inner
        Response of the controller in the inner loop of the synchronous control (`sampled_receptance.inner_response`),
        if there is such a controller.
    reason
        Reason for a failure; otherwise empty.
    interrupted
        Whether Ctrl-C interrupted the identification.
    """

    speed: Annotated[float, "rad/s"]
    order: int
    periods: int
    force: Annotated[float, "N"]
    receptance: Annotated[Complex | None, "m/N"]
    model: Annotated[Complex | None, "m/N"]
    inner: Annotated[Complex | None, "N/m"] = None
    reason: str = ""
    interrupted: bool = False

    @property
    def frequency(self) -> float:
        """Spin speed (Hz)."""
        return self.speed / (2.0 * math.pi)


def prepare_identification(
    Omega: float,
    rotor: RotorSource = None,
    settings: Mapping[str, Raw] | None = None,
    options: RunOptions = DEFAULTS,
    machine: Scenario | None = None,
) -> Machine:
    """Return the machine for an identification of the levitated rotor, ready to run.

    Parameters
    ----------
    Omega
        Spin speed (rad/s).
    rotor
        A `Rotor`, the name of a packaged rotor, or a rotor file; by default the rotor of `machine`, or else the packs'
        default.
    settings
        Values by `component.variable`, numbers or strings with units.
    options
        Options of the run; only the flavour of the FMUs is used.
    machine
        Scenario that defines the machine and its parameters; by default, the start values of the FMUs are used.

    Raises
    ------
    ValueError
        If the speed is not positive or is below `rolac.min_speed`, or if another setting is not allowed.
    """
    default_machine = make_scenario({"Omega": 1.0, "communication_step": STEP, "end_time": STEP}, NAME)
    base = as_scenario((machine or default_machine).machine(), rotor)
    step = base.step_size("gauss_seidel")
    n_axes = 2 * len(load_rotor(base.rotor).bearings)
    revolutions = (n_axes + 2) * periods(Omega / (2.0 * math.pi)) + MARGIN
    steps = math.ceil(in_steps(revolutions * 2.0 * math.pi / Omega, step)) if Omega > 0.0 else 1
    scenario = base.changed(
        description="Identification of the receptance",
        Omega=Omega,
        settle_cycles=0,
        end_time=steps * step,
        coupling="gauss_seidel",
        inputs={CONTROLLER: {"identify": True}},
        parameters={CONTROLLER: {"contact.source": GIVEN}},
        record={"variables": RECORDED, "every": steps},
    )
    prepared = prepare_run(scenario, settings, options=options)
    if prepared.speed != Omega:
        raise ValueError("Omega cannot be set here; speeds sets it")
    identified_machine = machine_of(prepared, ACTUATOR, CONTROLLER)
    lowest = identified_machine.parameters[CONTROLLER]["rolac.min_speed"]
    if Omega < lowest and not math.isclose(Omega, lowest):
        unit = speed_unit()
        raise ValueError(
            f"speeds = {unit.text(Omega)} is not allowed; it must be >= {unit.text(lowest)}, rolac.min_speed"
        )
    return identified_machine


def table_for(machine: Machine, path: Path | None) -> ReceptanceTable:
    """Return the table in a file or, if there is no such file, an empty table for the rotor and loop of a machine.

    Raises
    ------
    ValueError
        If the file is not a complete table, or belongs to another rotor or loop.
    """
    parameters, controlled, name = machine.parameters[CONTROLLER], machine.controlled, machine.rotor.name
    inner = inner_loop_parameters(machine.prepared.assembly.system, machine.parameters)
    if path is not None and path.exists():
        return read_table(path, name, controlled, {**loop_parameters(controlled, parameters), **inner})
    return empty_table(name, controlled, parameters, inner)


def run_identification(machine: Machine, progress: Progress | None = None) -> IdentifiedReceptance:
    """Run an identification to its end and return its result.

    `progress` is called with the number of finished steps and the number of all steps.
    """
    identification = _identification(machine)
    model = sampled_receptance(machine, identification.order)
    result = execute(machine.prepared, RunOptions(progress=progress))
    receptance, reason = None, result.outcome.failure or ""
    if result.outcome.failure is None:
        receptance, reason = _result(result.dataset.isel(time=-1), machine.controlled)
    interrupted = result.outcome.status == "interrupted"
    return replace(identification, receptance=receptance, model=model, reason=reason, interrupted=interrupted)


def computed_identification(machine: Machine) -> IdentifiedReceptance:
    """Return the receptance from the linear model of the loop, without a simulation or a comparison."""
    identification = _identification(machine)
    receptance = sampled_receptance(machine, identification.order)
    if condition_number(receptance) > MAX_CONDITION:
        return replace(identification, reason=ERRORS.sentences[ILL_CONDITIONED])
    return replace(identification, receptance=receptance)


def _identification(machine: Machine) -> IdentifiedReceptance:
    """Return the result of an identification before its run, which has no receptances yet."""
    order = int(machine.parameters[CONTROLLER]["harmonic1.order"])
    return IdentifiedReceptance(
        speed=machine.Omega,
        order=order,
        periods=int(periods(machine.Omega / (2.0 * math.pi))),
        force=force_amplitude(machine),
        receptance=None,
        model=None,
        inner=inner_response(machine, order),
    )


def force_amplitude(machine: Machine) -> float:
    """Return the amplitude of the test force in the first harmonic (N)."""
    parameters = parameters_of_loop(machine.controlled, machine.parameters[CONTROLLER])
    identification = parameters.common[0].identification
    multi, scale = identification.multi != 0.0, identification.force_scale
    return abs(force_component(parameters.harmonics, 0, multi, scale, machine.Omega / (2.0 * math.pi)))


def _result(outputs: xr.Dataset, loop: ControlLoop) -> tuple[Complex | None, str]:
    """Return R at the end of a run, or None and the reason for the failure."""
    state, error = (int(outputs[f"rolac_controller.identification_{name}"]) for name in ("state", "error"))
    last, sentences = last_stages(len(loop.axes)), stages(loop.axis_names).sentences
    if state != last.done:
        return None, ERRORS.sentences[
            error
        ] if state == last.failed else f"it did not reach its end: {sentences[state]}"
    receptance = receptance_of(outputs, loop)
    if condition_number(receptance) > MAX_CONDITION:  # the controller's limit is a parameter
        return None, ERRORS.sentences[ILL_CONDITIONED]
    return receptance, ""


def receptance_of(outputs: xr.Dataset, loop: ControlLoop) -> Complex:
    """Return R, shape (n_sensors, n_axes), complex (m/N), from the controller's outputs at one instant."""
    return np.array(
        [
            [
                complex(*(float(outputs[f"rolac_controller.r.{s}.{b}_{a}.{part}"]) for part in ("re", "im")))
                for b, a, _ in loop.axes
            ]
            for s in loop.sensor_names
        ]
    )


def ratios(receptance: Complex, model: Complex) -> Complex:
    """Return R divided by the model's R, where the latter exceeds a tenth of the largest element in its column."""
    size = np.abs(model)
    large = size > LARGE * size.max(axis=0)
    return np.asarray(receptance[large] / model[large], dtype=np.complex128)
