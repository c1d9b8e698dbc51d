"""Identification of the receptance by co-simulation: the controller FMU finds it on the plant FMU, speed by speed.

The run lasts as long as the six slots of the identification; R is read from the controller's outputs at its end.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from rich.table import Table

from amb_analysis.receptance_table import MAX_CONDITION, condition_number
from amb_analysis.table_file import ReceptanceTable, read_table
from amb_analysis.table_file import loop_of as loop_parameters
from amb_cosim.cosim.fmus import Flavour
from amb_cosim.cosim.simulation import Progress
from amb_cosim.plan import parse_settings
from amb_cosim.scenario import make_scenario
from amb_cosim.simulation import Prepared, prepare, run_prepared
from amb_cosim.studies.loop import Loop, loop_of
from amb_cosim.studies.sampled_receptance import sampled_receptance
from rolac_controller.excitation import component, periods
from rolac_controller.names import AXES, DONE, ERRORS, FAILED, GIVEN, ILL_CONDITIONED, N_HARMONICS, SENSOR_NAMES, STAGES

Complex = NDArray[np.complex128]

STEP = 250e-6  # s
SPARE = 2.0  # revolutions: one fills the window before the first slot, and the last sample must not be missed
LARGE = 0.1  # of the largest element of its column: smaller elements are not compared
NAME = "identification"
RECORDED = ["rolac_controller.r.*", "rolac_controller.identification_*"]


@dataclass(frozen=True)
class Identified:
    """What a run at one speed found.

    Omega
        Spin speed (rad/s).
    order
        The harmonic that was excited.
    periods, force
        Revolutions of a slot, and amplitude of the test force (N).
    receptance
        R, shape (8, 4), complex (m/N); None if there is none.
    model
        R of the linear model of the same sampled loop.
    reason
        Why there is none; empty where there is one.
    interrupted
        Whether the reason is Ctrl-C.
    """

    Omega: float
    order: int
    periods: int
    force: float
    receptance: Complex | None
    model: Complex
    reason: str = ""
    interrupted: bool = False

    @property
    def frequency(self) -> float:
        """Spin speed in Hz."""
        return self.Omega / (2.0 * math.pi)


def prepared_run(
    Omega: float, rotor_file: Path | None = None, settings: Iterable[str] = (), flavour: Flavour = "python"
) -> Prepared:
    """An identification of the levitated rotor at a speed (rad/s), ready to run.

    Parameters
    ----------
    rotor_file
        The rotor; the rig of the thesis by default.
    settings
        Texts `component.variable=value`, as of `amb-cosim run --set`.

    Raises
    ------
    ValueError
        If the speed is not positive or below `rolac.min_speed`, or anything else does not fit.
    """
    revolutions = 6 * periods(Omega / (2.0 * math.pi)) + SPARE
    steps = math.ceil(revolutions * 2.0 * math.pi / Omega / STEP) if Omega > 0.0 else 1
    scenario = make_scenario(
        {
            "description": "Identification of the receptance",
            "Omega": Omega,
            "settle_cycles": 0,
            "end_time": steps * STEP,
            "communication_step": STEP,
            "rotor": None if rotor_file is None else str(rotor_file),
            "inputs": {"rolac_controller": {"identify": True}},
            "parameters": {"rolac_controller": {"contact.source": GIVEN}},
            "record": {"variables": RECORDED, "every": steps},
        },
        NAME,
    )
    prepared = prepare(scenario, parse_settings(settings), flavour=flavour)
    if prepared.plan.speed != Omega:
        raise ValueError("Omega cannot be set here; --speeds sets it")
    least = loop_of(prepared).parameters["rolac_controller"]["rolac.min_speed"]
    if Omega < least and not math.isclose(Omega, least):
        raise ValueError(f"speeds = {Omega:g} rad/s is not allowed; it must be >= {least:g} rad/s, rolac.min_speed")
    return prepared


def table_for(prepared: Prepared, path: Path) -> ReceptanceTable:
    """The table in a file, or an empty one for the rotor and loop of a prepared run if there is no file yet.

    Raises
    ------
    ValueError
        If the file is no whole table, or is of another rotor or loop.
    """
    loop = loop_of(prepared)
    wanted = loop_parameters(loop.parameters["rolac_controller"])
    if path.exists():
        return read_table(path, loop.rotor.name, wanted)
    return ReceptanceTable(loop.rotor.name, wanted)


def identified(prepared: Prepared, progress: Progress | None = None) -> Identified:
    """Run an identification to its end and read what it found."""
    loop = loop_of(prepared)
    order = int(loop.parameters["rolac_controller"]["harmonic1.order"])
    result = run_prepared(prepared, progress)
    receptance, reason = None, result.outcome.failure or ""
    if result.outcome.failure is None:
        receptance, reason = _found(result.dataset.isel(time=-1))
    return Identified(
        Omega=loop.Omega,
        order=order,
        periods=int(periods(loop.Omega / (2.0 * math.pi))),
        force=force_amplitude(loop),
        receptance=receptance,
        model=sampled_receptance(loop, order),
        reason=reason,
        interrupted=result.outcome.status == "interrupted",
    )


def force_amplitude(loop: Loop) -> float:
    """Amplitude of the test force in the first harmonic (N)."""
    parameters = loop.parameters["rolac_controller"]
    orders, powers = (
        np.array([parameters[f"harmonic{k}.{name}"] for k in range(1, N_HARMONICS + 1)]) for name in ("order", "power")
    )
    multi, scale = parameters["identification.multi"] != 0.0, parameters["identification.force_scale"]
    return abs(complex(*component(orders, powers, 0, multi, scale, loop.Omega / (2.0 * math.pi))))


def _found(outputs: xr.Dataset) -> tuple[Complex | None, str]:
    """R at the end of a run, or why there is none."""
    state, error = (int(outputs[f"rolac_controller.identification_{name}"]) for name in ("state", "error"))
    if state != DONE:
        return None, ERRORS[error] if state == FAILED else f"it did not come to its end: {STAGES[state]}"
    receptance = receptance_of(outputs)
    if condition_number(receptance) > MAX_CONDITION:  # the controller's own limit is a parameter
        return None, ERRORS[ILL_CONDITIONED]
    return receptance, ""


def receptance_of(outputs: xr.Dataset) -> Complex:
    """R, shape (8, 4), complex (m/N), that the controller shows at an instant."""
    return np.array(
        [
            [
                complex(*(float(outputs[f"rolac_controller.r.{s}.{b}_{a}.{part}"]) for part in ("re", "im")))
                for b, a, _ in AXES
            ]
            for s in SENSOR_NAMES
        ]
    )


def ratios(receptance: Complex, model: Complex) -> Complex:
    """R over R of a model, element by element, where the model's is above a tenth of its column's largest."""
    size = np.abs(model)
    large = size > LARGE * size.max(axis=0)
    return np.asarray(receptance[large] / model[large], dtype=np.complex128)


def as_table(results: Iterable[Identified]) -> Table:
    """What was found at each speed, to print."""
    table = Table(title="Identification", title_justify="left", box=None, padding=(0, 2, 0, 0))
    for heading in ("speed (Hz)", "periods", "force (N)", "condition number", "differs from the model (%)"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("")
    for result in results:
        figures: tuple[Any, ...] = ("-", "-")
        if result.receptance is not None:
            difference = np.abs(ratios(result.receptance, result.model) - 1.0).max()
            figures = (f"{condition_number(result.receptance):.3f}", f"{100.0 * difference:.2g}")
        done = result.reason or "done"
        table.add_row(f"{result.frequency:.6g}", str(result.periods), f"{result.force:.1f}", *figures, done)
    return table
