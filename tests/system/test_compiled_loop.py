"""The compiled loop and the plain one record the same, to the last bit, with real FMUs of both flavours.

Every output of all three FMUs is compared: energies, currents, forces, contact modes, flags. The rotor touches its
retainer bearings in every scenario.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest

needs_compiler = pytest.mark.skipif(find_spec("ziglang") is None, reason="a native FMU is compiled by ziglang")

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
        "last": planned.plan.last,
    }


@needs_compiler
@pytest.mark.slow
@pytest.mark.gate
@pytest.mark.parametrize("name", SCENARIOS)
def test_both_loops_record_the_same(name: str) -> None:
    check(with_both_loops(SCENARIOS[name], "native"), name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [pytest.param("gauss_seidel", marks=pytest.mark.gate), "fine_jacobi", "profile"])
def test_both_loops_record_the_same_of_flavour_python(name: str, run_python: Callable[..., Any]) -> None:
    check(run_python(with_both_loops, scenario=SCENARIOS[name], flavour="python", timeout=600), name)


def check(result: dict[str, Any], name: str) -> None:
    assert result["variables"] >= sum(result["outputs"])
    assert result["differing"] == []
    assert result["attributes"] == []
    assert result["failures"] == [None, None]
    assert result["contact"][-1] > 0, "a run without contact would show less"
    assert result["every"] == [1, 1, 1]
    assert result["points"][-1] + (3 if name == "profile" else 1) > result["last"]
