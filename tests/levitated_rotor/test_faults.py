"""A fault of a part names its component and the value, at the sample where the orchestrator has it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from assembled_rotor import Host, T, in_one, separate

from amb_cosim.cosim.errors import StartFailed
from amb_cosim.scenario.plan import ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from tests.support.messages import assert_names, raises_naming

# A magnet so near that the rotor reaches it; no retainers, and a rotor that runs away from its sensors.
NEAR = {"amb_actuator": {"mb?.gap_?": "0.1 mm", "mb?.k_s_measured_?": 0.0}}
AWAY = {
    "rotor_contact": {"rb?.enabled": False, "eb?.enabled": False},
    "amb_actuator": {"mb?.gap_?": 1.0},
    "rolac_controller": {"mb?.k_b_?": -1e7},
}


def scenario(parameters: dict[str, Any]) -> Any:
    changes = {"settle_cycles": 0, "end_cycle": 8, "inputs": {"rotor_contact": {"d1.u": "30 g.m"}}}
    return load_scenario("fig4_9").changed(parameters=parameters, **changes)


@pytest.fixture(scope="module", params=["NEAR", "AWAY"])
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[ScenarioPlan, Path]:
    mine = scenario({"NEAR": NEAR, "AWAY": AWAY}[request.param])
    return prepare_run(mine), mine.save(tmp_path_factory.mktemp("scenario") / f"{request.param.lower()}.toml")


def test_a_fault_has_the_time_and_message_of_the_orchestrator(case: Any, assembled: Callable[..., Path]) -> None:
    prepared, file = case
    of_three, of_one = separate(prepared).outcome, in_one(prepared, assembled(file)).outcome
    assert of_three.status == of_one.status == "failed"
    assert of_three.component in ("amb_actuator", "rolac_controller")
    assert of_one.time == of_three.time
    assert of_one.reason == of_three.reason.replace(": ", f": {of_three.component}: ", 2).replace(
        f"{of_three.component}: ", "", 1
    )


@pytest.mark.parametrize("samples", [1, 5, 0.7])
def test_fault_in_a_long_step_has_the_value_at_the_sample(
    case: Any, samples: float, assembled: Callable[..., Path], extracted: Callable[..., Path]
) -> None:
    prepared, file = case
    of_three = separate(prepared).outcome
    host, k = Host(extracted(file)).begin(), 0
    while host.step(k * samples * T, samples * T) == 0:
        before, k = host.read(), k + 1
    message = of_three.reason.partition(": at t = ")[2].partition(": ")[2]
    reason = host.slave.reason()
    if samples != 0.7:
        assert f"{of_three.component}: {message}" in reason
    assert f"{of_three.component}: " in reason
    assert k * samples * T == pytest.approx(of_three.time, abs=1.01 * max(samples, 1.0) * T)
    assert host.read() == before, "outputs keep their last good values"
    (code,) = host.slave.get("fault_code")
    assert 200 < code < 300 if of_three.component == "amb_actuator" else 1000 <= code < 100_000


def test_a_fault_of_a_part_at_the_start_is_reported(
    assembled: Callable[..., Path], extracted: Callable[..., Path]
) -> None:
    prepared = prepare_run(scenario({"amb_actuator": {"mb2.bias_current_y": "11 A"}}))
    with raises_naming(StartFailed, "mb2.bias_current_y", "11 A") as refused:
        separate(prepared)
    host = Host(extracted("fig4_9"))
    host.slave.set(amb_actuator__mb2__bias_current_y=11.0)
    host.slave.setup()
    assert host.slave.call("EnterInitializationMode") == 0
    assert host.slave.call("ExitInitializationMode") == 3
    assert str(refused.value).rpartition("initialisation: ")[2] in host.slave.reason()
    assert "amb_actuator: amb_actuator.mb2" not in host.slave.reason()


@pytest.mark.parametrize("samples", [1, 4])
def test_a_force_beyond_all_bounds_is_a_fault_of_the_plant(samples: int, extracted: Callable[..., Path]) -> None:
    """And not of the controller, which its displacements would reach in the next piece."""
    host = Host(extracted("fig4_9")).begin()
    assert host.step(0.0, T) == 0
    before = host.read()
    host.set({"rotor_contact.d1.f_x": 1e300, "rotor_contact.d2.f_x": -1e308})
    assert host.step(T, samples * T) != 0
    assert host.slave.reason().startswith("rotor_contact")
    (code,) = host.slave.get("fault_code")
    assert 300 < code < 400 or code >= 100_000
    assert host.read() == before


def test_an_excessively_long_step_is_refused(assembled: Callable[..., Path], extracted: Callable[..., Path]) -> None:
    host = Host(extracted("fig4_9")).begin()
    assert host.step(0.0, 1e9) == 3
    assert_names(host.slave.reason(), "step size", "1e+09 s", "1e+06")
    assert host.slave.get("fault_code") == [999]
