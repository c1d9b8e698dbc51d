"""What each model runs through as an FMU: parameters, and inputs that visit its limits, contacts and faults."""

import itertools
import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from instances import initialised
from rig import ACTUATOR, ACTUATOR_CONSTANTS, AXES, CONTROLLER, SENSOR_NAMES, pack

from amb_cosim import linear_controller
from amb_cosim.controllers.linear_controller import LinearController
from amb_cosim.model_constants.plant_data import plant
from fmi_export.model import Array, Model

SPEED = 2.0 * math.pi * 30.3
STIFFNESS = {f"mb{k}.k_{a}{a}": -1e6 for k in (1, 2) for a in "xy"}
RUB = {"rb1.mu": 0.3, "rb2.mu": 0.3, "rb1.restitution": 0.2, "mb1.c_b": 5e3, "mb2.c_b": 5e3, "contact.impact_law": 1}
LOADS = {"Omega": 180.0, "d1.u": 0.06, "d3.u": 0.03, "d3.phi": 1.0, "base.a_y": 2.0} | STIFFNESS
RIG_CHAIN = {"sample_time": 1e-3, "chain.preset": 1, "chain.seed": 77, "contact.aware": 1, "derivative_time": 1e-3}
RIG_CHAIN_ALONE = {"chain.preset": 1, "chain.seed": 5, "chain.cutoff": 300.0}
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
    values = {}
    for k, (b, a) in enumerate(AXES):
        values[f"{b}.i_{a}"] = 6.0 * math.sin(0.05 * n * (k + 1)) if n % 40 < 30 else 0.1 * k
        values[f"{b}.command_voltage_{a}"] = 0.2 * math.cos(0.3 * n)
        values[f"{b}.{a}"] = 7e-4 * math.sin(0.031 * n + k)
        values[f"{b}.coil_loss_upper_{a}"] = 0.4 if 60 <= n < 90 else 0.0
        values[f"{b}.coil_loss_lower_{a}"] = 1.0 if 80 <= n < 100 else 0.0
        values[f"{b}.amplifier_off_{a}"] = float(110 <= n < 130 + k)
        values[f"{b}.stuck_{a}"] = float(150 <= n < 160 + k)
    return values


def of_controller(n: int) -> dict[str, float]:
    """Contact, adaptation, an identification, and a stuck sensor."""
    theta, size = SPEED * 1e-3 * n, 7e-4 if n < 120 else 1e-4
    values = {name: size * math.cos(theta + k) + 1e-5 for k, name in enumerate(SENSOR_NAMES)}
    values |= {"Omega": SPEED, "theta": theta % (2.0 * math.pi), "rolac_enable": 1.0}
    return values | {"contact_state": float(n < 120), "identify": float(n >= 160), "s3.fault_stuck": float(n >= 300)}


def receptance_table() -> Array:
    """Random receptances at two speeds."""
    rng = np.random.default_rng(7)
    return pack([50.0, 400.0], 1e-6 * (rng.normal(size=(2, 8, 4)) + 1j * rng.normal(size=(2, 8, 4))))


def laws_over_speed() -> LinearController:
    """A filter of third order and a PI, mixed, for two speeds, with limits and a delay between two samples."""
    rng = np.random.default_rng(8)
    filters = [np.array([[0.9, 0.2, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.0, slow]]) for slow in (0.5, 0.7)]
    laws = {}
    for speed, A in zip((100.0, 300.0), filters, strict=True):
        law = np.zeros((4, 4))
        law[np.ix_([0, 2, 3], [0, 2, 3])] = A
        law[1, 1] = 1.0
        laws[speed] = (law, rng.normal(size=(4, 3)), rng.normal(size=(2, 4)), rng.normal(size=(2, 3)))
    signals, demands = [f"y{k}" for k in range(3)], ["u.x", "u.y"]
    limits = (-0.05, 0.03)
    return linear_controller(laws, signals, demands, 1e-3, sampled_arrays=True, limits=limits, delay=1.5)


def of_linear_controller(n: int) -> dict[str, float]:
    """Signals that drive the demands to their limits, a run-up beyond the table, switches, a fault."""
    values = {f"y{k}": 2e-3 * math.sin(0.07 * n * (k + 1)) + 1e-3 * k for k in range(3)}
    values |= {"Omega": 50.0 + 1.5 * n, "enable": float(not 60 <= n < 75), "reset": float(120 <= n < 122)}
    return values | {"y1.fault_stuck": float(150 <= n < 170), "y0.setpoint": 1e-4, "u.y.feedforward": 1e-3}


LAWS_AND_AMPLIFIERS = itertools.product(range(3), range(2), range(2))
CASES = {
    "amb_actuator": Case(
        ACTUATOR,
        ACTUATOR_CONSTANTS,
        [dict(zip(("force_law", "amplifier", "mean_current"), mode, strict=True)) for mode in LAWS_AND_AMPLIFIERS],
        of_actuator,
        240,
    ),
    "linear_controller": Case(
        *laws_over_speed().model_and_constants,
        [{}, RIG_CHAIN_ALONE, {"delay": 3.0, "start_at_rest": 0.0, "transfer_time": 0.0}],
        of_linear_controller,
        220,
        1e-3,
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
        core = initialised(case.model, case.constants, parameters)
        for n in range(case.steps):
            for variable, value in case.inputs(n).items():
                core[variable] = value
            core.step(n * case.h, case.h)
            rows.append(core.outputs.copy())
    return np.reshape(rows, (len(case.runs), case.steps, -1))
