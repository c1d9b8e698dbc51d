"""The assembled FMU equals the three FMUs under the orchestrator to the last bit, in any host, at any step."""

import zipfile
from collections.abc import Callable
from ctypes import byref
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from assembled_rotor import RIG, Host, T, differing, in_one, inputs_at, separate, series, start_angle

from amb_cosim import build_assembled
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario

pytestmark = pytest.mark.gate

SCENARIOS = ("fig5_6", *(pytest.param(name, marks=pytest.mark.slow) for name in ("fig4_9", "fig6_13")))

SIMULATED = {"settling": "simulated"}  # as one FMU has it
SHORT = {"settle_cycles": 2, "end_cycle": 12, **SIMULATED}  # of fig4_9: contact all the same


def short(**changes: Any) -> ScenarioPlan:
    return prepare_run(load_scenario("fig4_9").changed(**{**SHORT, **changes}))


@pytest.mark.parametrize("name", SCENARIOS)
def test_assembled_fmu_equals_the_orchestrator_to_the_last_bit(name: str, assembled: Callable[..., Path]) -> None:
    prepared = prepare_run(load_scenario(name).changed(**SIMULATED))
    of_three, of_one = separate(prepared), in_one(prepared, assembled(name))
    assert of_three.outcome.status == of_one.outcome.status == "completed"
    result = series(of_three)
    assert differing(series(of_one), result) == []
    assert {0.0, 2.0} <= set(result["rotor_contact.contact_state"])
    assert of_three.warnings.keys() == {"rolac_controller", "amb_actuator", "rotor_contact"}
    expected = [
        text.replace(": ", f": {component}.", 1) for component, texts in of_three.warnings.items() for text in texts
    ]
    assert sorted(of_one.warnings[RIG]) == sorted(expected)


@pytest.mark.parametrize("step", [25.0, 125.0])
def test_steps_of_a_fraction_of_the_sample_time_are_equal(step: float, assembled: Callable[..., Path]) -> None:
    """The controller samples at its own instants; actuator and rotor step with the master."""
    prepared = short(communication_step=f"{step} us", settle_cycles=0, end_cycle=7)
    assert differing(series(in_one(prepared, assembled("fig4_9"))), series(separate(prepared))) == []


def test_jacobi_order_is_equal(assembled: Callable[..., Path], native_lag: Path) -> None:
    prepared = short()
    beside = in_one(prepared, assembled("fig4_9"), {"lag": native_lag}, coupling="jacobi")
    assert differing(series(beside), series(separate(prepared))) == []


def step_through_contact(folder: str) -> dict[str, float]:
    import os
    from pathlib import Path

    os.environ["NUMBA_DISABLE_JIT"] = "1"
    from tests.support.assembled_rotor import Host, T

    host = Host(Path(folder)).begin(rotor_contact__d1__u=0.3)
    for k in range(40):
        assert host.step(k * 1.5 * T, 1.5 * T) == 0
    return host.read()


@pytest.mark.slow
def test_python_flavour_is_equal(
    extracted: Callable[..., Path], run_python: Callable[..., Any], tmp_path: Path
) -> None:
    """Its kernels, run by Python itself."""
    with zipfile.ZipFile(build_assembled(tmp_path, "fig4_9", "python")) as archive:
        archive.extractall(tmp_path / "fmu")
    result = run_python(step_through_contact, folder=tmp_path / "fmu")
    assert result["rotor_contact.contact_state"] > 0
    assert result == run_python(step_through_contact, folder=extracted("fig4_9"))


def over_steps(at_samples: dict[str, Any], warnings: set[str], ends: list[int]) -> dict[str, list[float]]:
    """Return outputs at the ends of steps of several samples, from the outputs at each sample."""
    outputs = {}
    for name, values in at_samples.items():
        spans = [values[a + 1 : b + 1] for a, b in pairwise(ends)]
        if name.endswith(".impulse"):
            outputs[name] = [sum(span.tolist()) for span in spans]
        elif name.endswith(".f_n_mean"):
            outputs[name] = [pytest.approx(np.mean(span), rel=1e-9) for span in spans]
        elif name in warnings or name.endswith((".f_n_peak", ".solver.method")):
            outputs[name] = [max(span) for span in spans]
        else:
            outputs[name] = [span[-1] for span in spans]
    return outputs


@pytest.mark.parametrize("rollback", [False, True])
def test_steps_of_any_length_are_equal_if_a_host_subtracts_times(
    rollback: bool, extracted: Callable[..., Path]
) -> None:
    """Communication points are n T, computed, and steps their differences, as in PyFMI; logging is off."""
    plan = short()
    three = series(separate(plan))
    warnings = {f"{c}.{p.name}" for c, i in plan.interfaces.items() for p in i.of("output") if p.warning}
    changes, sizes = inputs_at(plan, plan.first, plan.last), [1, 3, 2, 7, 1, 1, 12]
    host = Host(extracted("fig4_9"))
    start = plan.inputs | start_angle(plan)
    host.begin(plan.first * T, **{name.replace(".", "__"): value for name, value in start.items()})
    n, ends, result, state = plan.first, [0], [], None
    while n < plan.last:
        host.set(changes.get(n, {}))
        stop = min([plan.last, n + sizes[len(result) % len(sizes)], *(at for at in changes if at > n)])
        if rollback and len(result) % 10 == 3:
            state = host.slave.save(state)
            retained = host.read()
            host.set({"rotor_contact.d1.u": 0.02, "rolac_controller.mb1.set_x": 1e-4})
            assert host.step(n * T, 1.7 * T) == 0
            assert host.step(n * T + 1.7 * T, 0.6 * T) == 0
            assert host.slave.call("SetFMUstate", state) == 0
            assert host.read() == retained
        assert host.step(n * T, stop * T - n * T) == 0
        n = stop
        ends.append(n - plan.first)
        result.append(host.read())
    expected = over_steps(three, warnings, ends)
    assert [name for name in expected if [point[name] for point in result] != expected[name]] == []
    assert max(expected["rotor_contact.rb1.impulse"]) > 0.01
    peak, at_end = expected["rotor_contact.rb1.f_n_peak"], three["rotor_contact.rb1.f_n_peak"][ends[1:]]
    assert any(peak > at_end)
    if state is not None:
        assert host.slave.call("FreeFMUstate", byref(state)) == 0


def test_a_step_across_samples_is_split_at_them(extracted: Callable[..., Path]) -> None:
    """Steps of 0.7 samples, against steps that end at each sample and where those end."""
    long, fine = (Host(extracted("fig4_9")).begin(rotor_contact__d1__u=0.06) for _ in range(2))
    marks = sorted({0.7 * T * k for k in range(701)} | {T * k for k in range(491) if k % 7})
    touched = False
    for k in range(700):
        assert long.step(0.7 * T * k, 0.7 * T) == 0
        touched = touched or long.slave.get("rotor_contact.contact_state") != [0]
    for a, b in pairwise(marks):
        assert fine.step(a, b - a) == 0
    coarse_outputs, fine_outputs = long.read(), fine.read()
    assert touched
    for name in ("rotor_contact.mb1.x", "rotor_contact.mb2.y", "rolac_controller.mb1.i_x", "amb_actuator.mb1.f_x"):
        assert coarse_outputs[name] == pytest.approx(fine_outputs[name], rel=1e-6), name


@pytest.mark.parametrize("samples", [1.0, 4.0 / 3.0, 0.4, 0.25, 2.5, 3.0])
def test_rounding_of_the_times_of_a_host_moves_no_sample(samples: float, extracted: Callable[..., Path]) -> None:
    """Times that are late by up to half a millionth of the sample, as those of a host that adds up its steps."""
    h, late = samples * T, np.random.default_rng(1).uniform(0.0, 5e-7 * T, 60).tolist()
    exact, rounded = (Host(extracted("fig4_9")).begin(rotor_contact__d1__u=0.02) for _ in range(2))
    currents: list[list[float]] = []
    for k, rounding in enumerate(late):
        assert exact.step(k * h, h) == rounded.step(k * h + rounding, h) == 0
        currents.append([host.read()["rolac_controller.mb1.i_x"] for host in (exact, rounded)])
    right, found = np.array(currents).T
    assert np.unique(right).size == min(60, round(60 * samples))
    np.testing.assert_allclose(found, right, atol=1e-5 * np.ptp(right))


def test_the_speed_rises_within_a_long_step(extracted: Callable[..., Path]) -> None:
    slope, n = 400.0, 8  # rad/s2
    fine, long = (Host(extracted("fig4_9")).begin(Omega_dot=slope) for _ in range(2))
    for k in range(4 * n):
        fine.set({"Omega": 260.0 + slope * k * T})
        assert fine.step(k * T, T) == 0
    for k in range(4):
        long.set({"Omega": 260.0 + slope * k * n * T})
        assert long.step(k * n * T, n * T) == 0
    fine_outputs, coarse_outputs = fine.read(), long.read()
    for name in ("rotor_contact.speed", "rotor_contact.theta", "rotor_contact.mb1.x", "rolac_controller.mb1.i_x"):
        assert fine_outputs[name] == pytest.approx(coarse_outputs[name], rel=1e-9), name


def test_a_serialised_state_continues_the_run(extracted: Callable[..., Path]) -> None:
    first = Host(extracted("fig5_6")).begin()
    for k in range(40):
        assert first.step(0.4 * T * k, 0.4 * T) == 0
    text = first.slave.serialise(first.slave.save())
    second = Host(extracted("fig5_6")).begin()
    status, state = second.slave.deserialise(text)
    assert status == 0
    assert second.slave.call("SetFMUstate", state) == 0
    for k in range(40, 80):
        assert first.step(0.4 * T * k, 0.4 * T) == second.step(0.4 * T * k, 0.4 * T) == 0
    assert first.read() == second.read()


def test_a_rotor_of_another_size_is_equal(assembled: Callable[..., Path]) -> None:
    prepared = prepare_run(load_scenario("compressor_levitated").changed(settle_cycles=0, end_cycle=2))
    of_three, of_one = separate(prepared), in_one(prepared, assembled("compressor_levitated"))
    assert differing(series(of_one), series(of_three)) == []
