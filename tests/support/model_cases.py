"""What each model runs through as an FMU: parameters, and inputs that visit its limits, contacts and faults."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from rig import ACTUATOR, ACTUATOR_CONSTANTS, AXES, CONTROLLER, SENSOR_NAMES, pack

from amb_cosim.design.plant_data import plant
from fmi_export.model import Array, Instance, Model

SPEED = 2.0 * math.pi * 30.3
STIFFNESS = {f"mb{k}.k_{a}{a}": -1e6 for k in (1, 2) for a in "xy"}
RUB = {"rb1.mu": 0.3, "rb2.mu": 0.3, "rb1.restitution": 0.2, "mb1.c_b": 5e3, "mb2.c_b": 5e3, "contact.impact_law": 1}
LOADS = {"Omega": 180.0, "d1.u": 0.06, "d3.u": 0.03, "d3.phi": 1.0, "base.a_y": 2.0} | STIFFNESS
RIG_CHAIN = {"sample_time": 1e-3, "chain.preset": 1, "chain.seed": 77, "contact.aware": 1, "derivative_time": 1e-3}
RIG_CHAIN |= {"mb1.k_integral_x": 1e6, "s2.weight": 2.0, "plane2.offset": 0.03}


class Case(NamedTuple):
    """A model with its constants; the parameters of each run, the inputs of step n, steps and their length (s)."""

    model: Model
    constants: Array
    runs: list[dict[str, float]]
    inputs: Callable[[int], dict[str, float]]
    steps: int
    h: float = 250e-6


def of_actuator(n: int) -> dict[str, float]:
    """Every axis in and out of its limits, and each fault for a while."""
    given = {}
    for k, (b, a) in enumerate(AXES):
        given[f"{b}.i_{a}"] = 6.0 * math.sin(0.05 * n * (k + 1)) if n % 40 < 30 else 0.1 * k
        given[f"{b}.command_voltage_{a}"] = 0.2 * math.cos(0.3 * n)
        given[f"{b}.{a}"] = 7e-4 * math.sin(0.031 * n + k)
        given[f"{b}.coil_loss_upper_{a}"] = 0.4 if 60 <= n < 90 else 0.0
        given[f"{b}.coil_loss_lower_{a}"] = 1.0 if 80 <= n < 100 else 0.0
        given[f"{b}.amplifier_off_{a}"] = float(110 <= n < 130 + k)
        given[f"{b}.stuck_{a}"] = float(150 <= n < 160 + k)
    return given


def of_controller(n: int) -> dict[str, float]:
    """Contact, adaptation, an identification, and a stuck sensor."""
    theta, size = SPEED * 1e-3 * n, 7e-4 if n < 120 else 1e-4
    given = {name: size * math.cos(theta + k) + 1e-5 for k, name in enumerate(SENSOR_NAMES)}
    given |= {"Omega": SPEED, "theta": theta % (2.0 * math.pi), "rolac_enable": 1.0}
    return given | {"contact_state": float(n < 120), "identify": float(n >= 160), "s3.fault_stuck": float(n >= 300)}


def receptance_table() -> Array:
    """Random receptances at two speeds."""
    rng = np.random.default_rng(7)
    return pack([50.0, 400.0], 1e-6 * (rng.normal(size=(2, 8, 4)) + 1j * rng.normal(size=(2, 8, 4))))


LAWS_AND_AMPLIFIERS = itertools.product(range(3), range(2), range(2))
CASES = {
    "amb_actuator": Case(
        ACTUATOR,
        ACTUATOR_CONSTANTS,
        [dict(zip(("force_law", "amplifier", "mean_current"), mode, strict=True)) for mode in LAWS_AND_AMPLIFIERS],
        of_actuator,
        240,
    ),
    "rolac_controller": Case(
        CONTROLLER,
        receptance_table(),
        [RIG_CHAIN | {"rolac.mode": mode, "contact.source": 2 - mode % 2} for mode in range(4)],
        of_controller,
        400,
        1e-3,
    ),
    "rotor_contact": Case(*plant(), [RUB], lambda n: LOADS | {"mb1.f_x": 50.0 if n < 100 else -50.0}, 200),
}


@cache
def core_outputs(name: str) -> Array:
    """Outputs of a model's core after each step, shape (runs, steps, outputs)."""
    case = CASES[name]
    rows = []
    for parameters in case.runs:
        core = Instance(case.model, case.constants)
        for variable, value in parameters.items():
            core[variable] = value
        core.initialise()
        for n in range(case.steps):
            for variable, value in case.inputs(n).items():
                core[variable] = value
            core.step(n * case.h, case.h)
            rows.append(core.outputs.copy())
    return np.reshape(rows, (len(case.runs), case.steps, -1))
