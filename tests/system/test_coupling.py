"""The co-simulation of the three FMUs, compared with the system integrated as a whole.

With its gradient the linear law is followed exactly, and what remains is the rotor's own fourth-order integration. The
orders of other couplings are in `test_convergence.py`.
"""

import math
import tomllib
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from monolithic import CLEARANCE, orbit_with_contact
from slow import slow_but_first

from amb_cosim.cosim.choices import Coupling
from amb_cosim.cosim.system.system_tables import Record
from amb_cosim.results.summary import Summary
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario, make_scenario
from amb_cosim.scenario.simulation import execute
from bath_thesis.studies.monolithic import Levitation, free_orbit

SCENARIO = """
description = "An unbalanced rotor from rest"
Omega = "{Omega} rad/s"
settle_cycles = 0
end_cycle = {cycles}
communication_step = "{step} us"

[inputs.rotor_contact]
"{disc}.u" = "{unbalance} kg.m"

[parameters.rotor_contact]
"contact.impact_law" = 0
{solver}

# With so many newtons per ampere no coil comes near its limits.
[parameters.amb_actuator]
force_law = 1
"*.k_s_measured_?" = "{k_s} N/m"
"*.k_i_measured_?" = "1e4 N/A"

[parameters.rolac_controller]
"*.k_s_?" = "{k_s} N/m"
"*.k_i_?" = "1e4 N/A"
"*.k_b_?" = "{k_b} N/m"
"*.c_b_?" = "{c_b} N.s/m"
"""


TIGHT = '"solver.tolerance" = 0'
FIXED = """
"solver.max_substep" = "{} us"
"solver.tolerance" = 1
"solver.exact_motion" = false
"""


@cache
def recorded(text: str, stride: int) -> dict[str, np.ndarray]:
    """Displacements and contact forces of a scenario, every `stride` points."""
    result = execute(prepare_run(make_scenario(tomllib.loads(text), "coupling")))
    assert result.outcome.failure is None, result.outcome.failure
    names = ["mb1.x", "mb1.y", "mb2.x", "mb2.y", "rb1.f_n", "rb2.f_n"]
    return {name: result.dataset[f"rotor_contact.{name}"].values[::stride] for name in names}


@pytest.fixture(scope="session")
def cosimulate() -> Callable[..., tuple[np.ndarray, np.ndarray]]:
    """Complex displacements at MB1 and MB2 and contact forces at each sample of the controller."""

    def run(
        case: Levitation, cycles: float, step: float = 250, substep: float | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        solver = TIGHT if substep is None else FIXED.format(substep)
        text = SCENARIO.format(**vars(case), cycles=cycles, step=step, solver=solver)
        x_1, y_1, x_2, y_2, f_1, f_2 = recorded(text, round(250 / step)).values()
        return np.array([x_1 + 1j * y_1, x_2 + 1j * y_2]).T, np.array([f_1, f_2]).T

    return run


@cache
def summary_in(coupling: Coupling, step: str | None = None, predicts: bool = True) -> Summary:
    """Return the summary of fig4_9 in an order, whose controller predicts in Jacobi order."""
    scenario = load_scenario("fig4_9").changed(coupling=coupling, communication_step=step)
    settings = {} if predicts else {"rolac_controller.prediction_time": 0.0}
    return execute(prepare_run(scenario.model_copy(update={"record": Record()}), settings)).summary


@pytest.mark.parametrize(
    ("step", "predicts", "recovers", "least", "most"),
    [
        (None, True, True, 0.0, 1e-3),
        ("50 us", False, True, 0.02, 0.05),
        ("250 us", False, False, 0.05, math.inf),
        ("250 us", True, True, 0.0, 0.05),
    ],
)
def test_jacobi_order_levitates_the_rig(step, predicts, recovers, least, most) -> None:
    """A step of a sample without prediction leaves it in contact for ten cycles, and is warned of as with prediction.

    What follows depends on the last bits: clearances that differ by 1e-12 make it undecided, trapped or unstable.
    """
    summary, sequential = summary_in("jacobi", step, predicts), summary_in("gauss_seidel")
    deviation = max(abs(summary.orbit_before[at] / radius - 1.0) for at, radius in sequential.orbit_before.items())
    assert least < deviation < most
    assert (summary.recovery == "recovered", sequential.recovery) == (recovers, "recovered")
    late = [text for text in summary.warnings if "Jacobi" in text]
    assert len(late) == (step == "250 us")
    assert all("500 µs after the displacements" in text for text in late)
    assert all(("predicts 500 µs" in text) == predicts for text in late)


FREE = Levitation(Omega=120.0, disc="d3", unbalance=0.02)
RUBBING = Levitation(
    Omega=260.0, disc="d1", unbalance=0.0255
)  # the unbalance of Fig. 4.9, from rest: both bearings touch


@pytest.mark.parametrize("step", slow_but_first([250, 125]))
def test_force_with_gradient_is_followed_exactly(cosimulate: Any, step: float) -> None:
    orbit, _ = cosimulate(FREE, 4, step=step)
    exact = free_orbit(FREE, len(orbit) - 1)
    assert np.abs(orbit - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.fixture(scope="module")
def rubbing() -> tuple[np.ndarray, np.ndarray]:
    return orbit_with_contact(RUBBING, 550)


@pytest.mark.slow
@pytest.mark.parametrize("step", [pytest.param(250, marks=pytest.mark.gate), 125])
def test_contact_phases_agree_with_the_monolithic_system(
    cosimulate: Any, rubbing: tuple[np.ndarray, np.ndarray], step: float
) -> None:
    """Impacts, rubbing and release at both bearings, 5.7 cycles: orbit to 1e-5 of the clearance, force to 1e-4."""
    exact_orbit, exact_force = rubbing
    assert np.all((exact_force > 0.0).sum(axis=0) > 100)
    orbit, force = cosimulate(RUBBING, 5.65, step=step)
    count = min(len(orbit), len(exact_orbit))
    assert count > 540
    assert np.abs(orbit[:count] - exact_orbit[:count]).max() < 1e-5 * CLEARANCE
    assert np.abs(force[:count] - exact_force[:count]).max() < 1e-4 * exact_force.max()


@pytest.mark.slow
def test_contact_converges_with_fourth_order_through_events(
    cosimulate: Any, rubbing: tuple[np.ndarray, np.ndarray]
) -> None:
    exact_orbit, _ = rubbing
    errors = []
    for substep in (125, 62.5):
        orbit, _ = cosimulate(RUBBING, 5.65, substep=substep)
        count = min(len(orbit), len(exact_orbit))
        errors.append(np.abs(orbit[:count] - exact_orbit[:count]).max())
    assert 12.0 < errors[0] / errors[1] < 24.0
