"""The compiled loop and the plain one record the same, to the last bit, with real FMUs of both flavours.

Every output of all three FMUs is compared: energies, currents, forces, contact modes, flags. The rotor touches its
retainer bearings in every scenario.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest

FLAVOURS = [
    "python",
    pytest.param(
        "native", marks=pytest.mark.skipif(find_spec("ziglang") is None, reason="a native FMU is compiled by ziglang")
    ),
]

UNBALANCE = """
description = "Unbalance comes and goes at 260 rad/s"
Omega = "260 rad/s"
settle_cycles = 3
end_cycle = 8

[inputs.rotor_contact]
"d1.u" = "0.5 g.m"

[[event]]
cycle = 1
set.rotor_contact."d1.u" = "25.5 g.m"

[[event]]
cycle = 6
set.rotor_contact."d1.u" = "0.5 g.m"
"""

RUN_UP = """
description = "Through the second critical speed, with contact"
Omega = "20 Hz"
settle_cycles = 1
end_time = "2 s"
inputs.rotor_contact."d1.u" = "16 g.m"

[[speed]]
time = "0.2 s"
Omega = "20 Hz"

[[speed]]
time = "1.9 s"
Omega = "28 Hz"

[record]
every = 3
settling = true
"""

SCENARIOS = {
    "gauss_seidel": UNBALANCE,
    "jacobi": 'coupling = "jacobi"\ncommunication_step = "250 us"\ngradient = false\n' + UNBALANCE,
    "fine": 'communication_step = "62.5 us"\n' + UNBALANCE,
    "fine_jacobi": 'coupling = "jacobi"\ncommunication_step = "62.5 us"\n' + UNBALANCE,
    "profile": RUN_UP,
    "boolean_input": UNBALANCE + "\n[[event]]\ncycle = 2\nset.rolac_controller.rolac_enable = true\n",
}

# The force throws the rotor out of the range of the sensors.
FAILING = UNBALANCE + '\n[[event]]\ncycle = 3.3\nset.rotor_contact."d1.f_x" = "1e7 N"\n'


STOPPING = (
    UNBALANCE
    + """
[[stop]]
variable = "rotor_contact.rb1.f_n"
above = "1 MN"

[[stop]]
variable = "rotor_contact.contact_state"
above = 0
from_cycle = 0.5

[record]
variables = ["amb_actuator.mb?.f_?"]
every = 3
"""
)


def with_both_loops(scenario: str, flavour: str) -> dict[str, Any]:
    """Return the differences between the loops, and what the compiled one recorded."""
    import numpy as np

    from amb_cosim.cosim.run.options import RunOptions
    from amb_cosim.scenario.plan_run import plan_run
    from amb_cosim.scenario.scenario import Record, parse_scenario
    from amb_cosim.scenario.simulation import run_planned

    parsed = parse_scenario(scenario, "case")
    if parsed.record.variables == ("*",):
        every = Record.model_validate(parsed.record.model_dump() | {"variables": ("*", "rolac_controller.r.*")})
        parsed = parsed.model_copy(update={"record": every})
    planned = plan_run(parsed, options=RunOptions(flavour=flavour))
    plain, fast = run_planned(planned, RunOptions(loop="plain")), run_planned(planned, RunOptions(loop="compiled"))
    assert list(plain.dataset.variables) == list(fast.dataset.variables)
    local = ("wall_s",)
    return {
        "differing": [
            name
            for name in plain.dataset.variables
            if plain.dataset[name].values.tobytes() != fast.dataset[name].values.tobytes()
        ],
        "attributes": [k for k, v in plain.dataset.attrs.items() if k not in local and fast.dataset.attrs[k] != v],
        "failures": [plain.outcome.failure, fast.outcome.failure],
        "points": np.rint(fast.dataset.time.values / planned.plan.step_size).astype(int).tolist(),
        "every": [c.every for c in planned.plan.system.components],
        "outputs": [len(i.of("output")) for i in planned.interfaces.values()],
        "variables": len(fast.dataset.data_vars),
        "contact": sorted(set(fast.dataset["rotor_contact.contact_state"].values.tolist())),
        "touching": int((fast.dataset["rotor_contact.contact_state"].values > 0).argmax()),
        "last": planned.plan.last,
        "stopped": fast.dataset.attrs["stopped"],
        "completed": fast.dataset.attrs["completed"],
        "simulated": fast.dataset.attrs["simulated_s"],
        "step": planned.plan.step_size,
    }


@pytest.mark.slow
@pytest.mark.gate
@pytest.mark.parametrize("flavour", FLAVOURS)
@pytest.mark.parametrize("name", SCENARIOS)
def test_both_loops_record_the_same(name: str, flavour: str, run_once: Callable[..., Any]) -> None:
    result = run_once(with_both_loops, scenario=SCENARIOS[name], flavour=flavour, timeout=600)
    assert result["variables"] >= sum(result["outputs"])
    assert result["differing"] == []
    assert result["attributes"] == []
    assert result["failures"] == [None, None]
    assert result["contact"][-1] > 0, "a run without contact would show less"
    assert result["every"] == [1, 1, 1]
    assert result["points"][-1] + (3 if name == "profile" else 1) > result["last"]


@pytest.mark.slow
@pytest.mark.parametrize("flavour", FLAVOURS)
def test_a_refused_step_ends_both_loops_alike(flavour: str, run_once: Callable[..., Any]) -> None:
    result = run_once(with_both_loops, scenario=FAILING, flavour=flavour, timeout=600)
    plain, fast = result["failures"]
    assert fast == plain
    assert fast.startswith("rolac_controller failed at t = ")
    assert ": fmi2DoStep answered Error: at t = " in fast
    assert " m is not allowed; it must be >= -0.1 and <= 0.1 m" in fast
    assert result["differing"] == []
    assert result["points"] == list(range(result["points"][-1] + 1))
    assert 300 < result["points"][-1] < result["last"]


@pytest.mark.slow
@pytest.mark.parametrize("flavour", FLAVOURS)
def test_both_loops_stop_at_the_first_contact(flavour: str, run_once: Callable[..., Any]) -> None:
    whole = run_once(with_both_loops, scenario=UNBALANCE, flavour=flavour, timeout=600)
    result = run_once(with_both_loops, scenario=STOPPING, flavour=flavour, timeout=600)
    assert result["differing"] == []
    assert result["attributes"] == []
    assert result["failures"] == [None, None]
    assert result["completed"] == 1
    first = whole["touching"]
    assert result["simulated"] == first * result["step"]
    assert result["stopped"] == f"rotor_contact.contact_state above 0, at t = {result['simulated']:.9g} s"
    assert result["points"] == list(range(0, first + 1, 3))
    assert result["variables"] < whole["variables"]


def interrupted(flavour: str, scenario: str) -> dict[str, Any]:
    """SIGINT from another thread, while other threads keep the interpreter busy."""
    import os
    import signal
    import threading

    from amb_cosim.cosim.run.options import RunOptions
    from amb_cosim.scenario.plan_run import plan_run
    from amb_cosim.scenario.scenario import parse_scenario
    from amb_cosim.scenario.simulation import run_planned

    text = scenario.replace("end_cycle = 8", "end_cycle = 2e4")
    planned = plan_run(parse_scenario(text, "case"), options=RunOptions(flavour=flavour))
    stop, started, done = threading.Event(), threading.Event(), []

    def busy() -> None:
        while not stop.is_set():
            sum(range(100))

    def send() -> None:
        started.wait()
        os.kill(os.getpid(), signal.SIGINT)

    def report(n: int, total: int) -> None:
        done.append(n)
        if n > 2000:
            started.set()

    threads = [threading.Thread(target=target) for target in (busy, busy, send)]
    for thread in threads:
        thread.start()
    try:
        result = run_planned(planned, RunOptions(progress=report))
    finally:
        stop.set()
        for thread in threads:
            thread.join()
    return {
        "failure": result.outcome.failure,
        "time": float(result.dataset.time[-1]),
        "simulated": result.dataset.attrs["simulated_s"],
        "points": result.dataset.sizes["time"],
        "settling": -planned.plan.first,
        "reports": done,
        "total": planned.plan.last - planned.plan.first,
    }


@pytest.mark.slow
@pytest.mark.parametrize("flavour", FLAVOURS)
def test_an_interrupt_ends_the_run_and_keeps_the_record(flavour: str, run_python: Callable[..., Any]) -> None:
    result = run_python(interrupted, flavour=flavour, scenario=UNBALANCE, timeout=300)
    assert result["failure"] == f"interrupted at t = {result['time']:.9g} s"
    assert result["time"] == result["simulated"]
    assert 2000 < result["points"] + result["settling"] < result["total"] / 2
    assert result["reports"] == sorted(result["reports"])
    assert len(result["reports"]) > 1
