"""The FMU as a host sees it. Every host is a subprocess: a pythonfmu FMU may harm the process it runs in."""

import math

import numpy as np
import pytest
from rig import ACTUATOR, ACTUATOR_CONSTANTS

from fmi_export.model import Instance

H = 250e-6


def random_inputs(n: int) -> list[list[float]]:
    """Inputs `u` and `hold` of the lag for n steps, clear of the values where it faults."""
    rng = np.random.default_rng(2006)
    return [[float(rng.uniform(-4, 4)), float(rng.integers(2))] for _ in range(n)]


def run_lag(path: str, inputs: list) -> list:
    from drive import Fmu

    fmu = Fmu(path, gain=3.0, offset=-2)
    rows = [fmu.outputs()]
    for n, (u, hold) in enumerate(inputs):
        fmu.set(u=u, hold=hold)
        assert fmu.step(n) == 0
        rows.append(fmu.outputs())
    fmu.close()
    return rows


def core_rows(model, inputs):
    core = Instance(model, np.zeros(1))
    core["gain"], core["offset"] = 3.0, -2.0
    core.initialise()
    rows = [core.outputs.tolist()]
    for n, (u, hold) in enumerate(inputs):
        core["u"], core["hold"] = u, hold
        core.step(n * H, H)
        rows.append(core.outputs.tolist())
    return rows


def test_the_fmu_gives_the_numbers_of_the_core_to_the_bit(lag, build_fmu, run_python):
    inputs = random_inputs(50)
    assert run_python(run_lag, path=build_fmu(lag), inputs=inputs) == core_rows(lag, inputs)


def test_outputs_follow_what_is_set_throughout_initialisation_mode(build_fmu, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path, initialise=False, mb1__i_x=1.0)
        forces = fmu.get("mb1.f_x")
        fmu.set(mb1__i_x=2.0)
        forces += fmu.get("mb1.f_x")
        fmu.set(mb1__turns_x=79.0)
        forces += fmu.get("mb1.f_x")
        fmu.fmi.exitInitializationMode()
        forces += fmu.get("mb1.f_x")
        fmu.set(mb1__i_x=0.0)
        forces += fmu.get("mb1.f_x")
        fmu.close()
        return forces

    one, two, fewer_turns, left, later = run_python(host, path=build_fmu(ACTUATOR, ACTUATOR_CONSTANTS))
    assert one > 0
    assert two == pytest.approx(2 * one, rel=1e-14)
    assert fewer_turns == pytest.approx(two / 4, rel=1e-14)
    assert left == fewer_turns
    assert later == left, "after initialisation outputs change by steps alone"


def test_reset_gives_a_new_run_with_start_values(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path, gain=3.0)
        runs = []
        for _ in range(2):
            fmu.set(u=2.0)
            run = [fmu.step(n) for n in range(5)] + fmu.outputs()
            runs.append(run)
            fmu.fmi.reset()
            fmu.fmi.setupExperiment(startTime=0.0)
            fmu.fmi.enterInitializationMode()
            fmu.fmi.exitInitializationMode()
        fmu.close()
        return runs

    first, second = run_python(host, path=build_fmu(lag))
    y = 5
    assert first[y] == pytest.approx(3 * second[y], rel=1e-14)
    assert first[y + 2] == second[y + 2] == 5
    assert second[y] == pytest.approx(2 * (1 - math.exp(-5 * H / 1e-3)), rel=1e-12)


def test_two_instances_do_not_share_anything(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        one, two = Fmu(path, gain=1.0), Fmu(path, gain=10.0)
        for n in range(4):
            one.set(u=1.0)
            two.set(u=-1.0)
            assert (one.step(n), two.step(n)) == (0, 0)
        answer = one.get("y") + two.get("y")
        one.set(u=5.0)
        answer += [one.step(4), two.step(4)]
        one.close()
        two.close()
        return answer

    y_one, y_two, *statuses = run_python(host, path=build_fmu(lag))
    assert y_two == pytest.approx(-10 * y_one, rel=1e-14)
    assert statuses == [3, 0]


@pytest.mark.slow
def test_two_hundred_instances_one_after_another_leave_the_process_alive(build_fmu, run_python):
    def host(path: str) -> list:
        import sys

        import fmpy
        from drive import Fmu

        folder = fmpy.extract(path)
        answers = set()
        for _ in range(200):
            fmu = Fmu(folder, mb1__x=1e-4)
            fmu.step(0)
            answers.add(fmu.get("mb1.f_x")[0])
            fmu.close()
        return [len(answers), len(sys.path)]

    answers, entries = run_python(host, path=build_fmu(ACTUATOR, ACTUATOR_CONSTANTS))
    assert answers == 1
    assert entries < 20, "sys.path must not grow with every instance"


def test_two_models_run_side_by_side_in_one_process(build_fmu, lag, run_python):
    def host(lag: str, actuator: str) -> list:
        from drive import Fmu

        one, two = Fmu(lag, u=1.0), Fmu(actuator, mb1__x=1e-4)
        statuses = [one.step(0), two.step(0)]
        answer = statuses + one.get("y") + two.get("mb1.f_x", "mb1.k_xx")
        two.close()
        one.close()
        return answer

    one, two, y, force, gradient = run_python(
        host, lag=build_fmu(lag), actuator=build_fmu(ACTUATOR, ACTUATOR_CONSTANTS)
    )
    assert (one, two) == (0, 0)
    assert y == pytest.approx(1 - math.exp(-0.25), rel=1e-12)
    assert force == pytest.approx(1e-4 * gradient, rel=1e-14)


def test_a_fault_is_an_error_logged_and_shown_as_fault_code(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path)
        fmu.set(u=5.0)
        answer = [fmu.step(3), *fmu.get("fault_code"), fmu.step(4), fmu.log]
        fmu.close()
        return answer

    first, code, second, log = run_python(host, path=build_fmu(lag))
    assert (first, code, second) == (3, 1, 3)
    assert log[0] == "at t = 0.00075 s: u = 5 V is 100 % too much (%s %n)", "printf formats must pass untouched"
    assert "stopped by an earlier fault: u = 5 V" in log[1]


def test_a_warning_is_logged_once_and_the_step_is_done(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path)
        statuses = []
        for n, u in enumerate((1.0, 4.0, 1.0, 3.5)):
            fmu.set(u=u)
            statuses += [fmu.step(n), *fmu.get("high")]
        answer = [statuses, fmu.log]
        fmu.close()
        return answer

    statuses, log = run_python(host, path=build_fmu(lag))
    assert statuses == [0, 0, 0, 1, 0, 0, 0, 1]
    assert log == ["at t = 0.0005 s: high: u = 4 V is above 3 V, half of what is allowed (100 %)"]


def test_a_fault_in_initialisation_can_be_put_right_before_its_end(build_fmu, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path, initialise=False, mb1__x=2e-3)
        answer = fmu.get("fault_code")
        fmu.set(mb1__x=1e-3)
        answer += fmu.get("fault_code")
        fmu.fmi.exitInitializationMode()
        answer += [fmu.step(0), fmu.log]
        fmu.close()
        return answer

    before, after, status, log = run_python(host, path=build_fmu(ACTUATOR, ACTUATOR_CONSTANTS))
    assert (before, after, status) == (1, 0, 0)
    assert log[0].startswith("initialisation: mb1.x = 0.002 m is not allowed")


def test_a_tunable_parameter_may_change_during_the_run(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path, u=1.0)
        fmu.set(gain=4.0)
        answer = [fmu.step(0), *fmu.get("y")]
        fmu.close()
        return answer

    status, y = run_python(host, path=build_fmu(lag))
    assert status == 0
    assert y == pytest.approx(4 * (1 - math.exp(-0.25)), rel=1e-12)
