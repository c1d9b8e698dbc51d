"""Native FMUs give the results of those that PythonFMU runs, also in a host without Python."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from command_line import run_program

TESTS = Path(__file__).parents[1]
HEADERS = Path(__file__).parents[2] / "libraries" / "fmi_export" / "building" / "native" / "fmi_headers"
KEEPS = {"Real": "r", "Integer": "i", "Boolean": "b"}

pytestmark = pytest.mark.slow

pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")


def both_flavours(name: str, until: float | None, settings: dict[str, Any]) -> dict[str, Any]:
    """Return which variables of a run differ in any bit, how many there are, and facts of the contact."""
    import amb_cosim

    native, python = (
        amb_cosim.run(name, set=settings, flavour=f, until=until, progress=False) for f in ("native", "python")
    )
    assert native.outcome == python.outcome
    assert native.outcome.failure is None
    names = list(native.signals.variables)
    assert names == list(python.signals.variables)
    different = [n for n in names if native.signals[n].values.tobytes() != python.signals[n].values.tobytes()]
    forces = {n.split(".")[1]: float(native.signals[n].values.max()) for n in names if n.endswith(".f_n")}
    return {"different": different, "forces": forces, "variables": len(names)}


RIG = dict.fromkeys(("fig4_9", "fig4_18", "fig5_6"))
SHORT = {"nelson_mcvaugh_rub": 0.024, "compressor_touchdown": 0.04, "compressor_levitated_touchdown": 0.04}  # s


CASES = [pytest.param(name, until, {}, None, id=name) for name, until in (RIG | SHORT).items()]
WORN = {"rotor_contact.rb?.clearance": "5 mm", "rotor_contact.eb?.enabled": False}
YIELDING = {"rotor_contact.rb?.law": "kelvin_voigt", "rotor_contact.rb?.k_c": "1e8 N/m", "rotor_contact.rb?.c_c": 1e4}
CASES += [
    pytest.param("drop", 0.03, WORN, "stator_mb1", id="drop onto the stators"),
    pytest.param("drop_no_race", 0.03, YIELDING, "rb1", id="drop under a force law"),
]


@pytest.mark.gate
@pytest.mark.parametrize(("name", "until", "settings", "touched"), CASES)
def test_both_flavours_give_the_same_bits(
    name: str, until: float | None, settings: dict[str, Any], touched: str | None, run_python: Callable[..., Any]
) -> None:
    result = run_python(both_flavours, name=name, until=until, settings=settings, timeout=600)
    assert result["different"] == []
    assert result["variables"] > (80 if name in RIG else 20)
    assert max(result["forces"].values()) > 100.0
    assert touched is None or result["forces"][touched] > 100.0


@pytest.mark.gate
@pytest.mark.skipif(sys.platform != "linux", reason="the host is built and run on Linux")
def test_a_c_program_gets_the_numbers_of_the_orchestrator_for_fig4_9(tmp_path: Path) -> None:
    """Python only writes the program's input: libraries, parameters, connections, events."""
    import numpy as np

    from amb_cosim.cosim.run.options import RunOptions
    from amb_cosim.scenario.plan_run import plan_run
    from amb_cosim.scenario.scenario import load_scenario
    from amb_cosim.scenario.simulation import run_planned

    planned = plan_run(load_scenario("fig4_9").changed(settling="simulated"), options=RunOptions(flavour="native"))
    command = [sys.executable, "-m", "ziglang", "cc", "-std=gnu11", "-O1", f"-I{HEADERS}"]
    run_program(*command, TESTS / "native" / "support" / "co_simulation.c", "-o", tmp_path / "host", "-ldl")
    program, names = instructions(planned)
    process = run_program(tmp_path / "host", input=program)
    table = np.array([[float.fromhex(word) for word in line.split()] for line in process.stdout.splitlines()])
    dataset = run_planned(planned).dataset
    assert len(table) == dataset.sizes["time"] > 1000
    for position, name in enumerate(names):
        np.testing.assert_array_equal(table[:, position], dataset[name].values.astype(float), err_msg=name)


def instructions(planned: Any) -> tuple[str, list[str]]:
    """Return the program's input, and the names of the columns that it prints."""
    plan, interfaces = planned.plan, planned.interfaces
    wiring, inputs, outputs = planned.assembly.wiring(plan.inputs, plan.recorded)
    head = f"components {len(plan.system.components)} first {plan.first} last {plan.last} step {plan.step_size!r}"
    lines = [f"{head} values {len(wiring.names)} exogenous {wiring.n_exogenous}"]
    position = wiring.n_exogenous
    for c, sources in zip(plan.system.components, wiring.sources, strict=True):
        ports, start = interfaces[c.name].ports, plan.parameters[c.name]
        library = planned.fmus[c.name].folder / "binaries" / "linux64" / f"{interfaces[c.name].identifier}.so"
        count = f"every {c.every} parameters {len(start)} inputs {len(inputs[c.name])} outputs {len(outputs[c.name])}"
        resources = (planned.fmus[c.name].folder / "resources").as_uri()
        lines.append(f"{library} {interfaces[c.name].guid} {resources} {c.name} {count}")
        lines += [f"{KEEPS[ports[name].type]} {ports[name].reference} {value!r}" for name, value in start.items()]
        for name, source in zip(inputs[c.name], sources.tolist(), strict=True):
            lines.append(f"{KEEPS[ports[name].type]} {ports[name].reference} {source}")
        for name in outputs[c.name]:
            lines.append(f"{KEEPS[ports[name].type]} {ports[name].reference} {position}")
            position += 1
    lines.append(f"events {len(plan.events)}")
    lines += [f"{n} {wiring.names.index(name)} {value!r}" for n, name, value in plan.events]
    lines.append("initial: " + " ".join(repr(float(value)) for value in plan.inputs.values()))
    recorded = [name for name in wiring.names if name in plan.recorded]
    assert recorded == list(wiring.names)
    return "\n".join(lines) + "\n", recorded
