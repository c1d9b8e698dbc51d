"""Native FMUs give the results of those that PythonFMU runs, also in a host without Python."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

TESTS = Path(__file__).parents[1]
HEADERS = Path(__file__).parents[2] / "libraries" / "fmi_export" / "building" / "native" / "fmi_headers"
KEEPS = {"Real": "r", "Integer": "i", "Boolean": "b"}

pytestmark = pytest.mark.slow

pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")


def largest_difference(name: str) -> dict[str, Any]:
    """Return the largest difference of any recorded variable, over its largest value, and facts of the runs."""
    import numpy as np

    from amb_cosim.scenario.scenario import load_scenario
    from amb_cosim.scenario.simulation import prepare, run_prepared

    runs = {}
    for flavour in ("python", "native"):
        result = run_prepared(prepare(load_scenario(name), flavour=flavour))
        assert result.outcome.failure is None, result.outcome.failure
        assert result.dataset.attrs["flavour"] == flavour
        runs[flavour] = result.dataset
    worst = 0.0
    for variable, expected in runs["python"].data_vars.items():
        found, expected = (np.asarray(v, dtype=float) for v in (runs["native"][variable], expected))
        assert found.shape == expected.shape
        worst = max(worst, float(np.max(np.abs(found - expected)) / max(np.max(np.abs(expected)), 1e-300)))
    contact = sorted(set(runs["native"]["rotor_contact.contact_state"].values.tolist()))
    return {"worst": worst, "variables": len(runs["python"].data_vars), "contact": contact}


@pytest.mark.parametrize("name", ["fig4_9", "fig4_18", "fig5_6"])
def test_both_flavours_give_the_same(name: str, run_python: Callable[..., Any]) -> None:
    found = run_python(largest_difference, name=name, timeout=600)
    assert found["variables"] > 80
    assert found["contact"][0] == 0
    assert found["contact"][-1] == 3
    assert found["worst"] < 1e-12


@pytest.mark.skipif(sys.platform != "linux", reason="the host is built and run on Linux")
def test_a_c_program_gets_the_numbers_of_the_orchestrator_for_fig4_9(tmp_path: Path) -> None:
    """Python only writes the program's input: libraries, parameters, connections, events."""
    import numpy as np

    from amb_cosim.scenario.scenario import load_scenario
    from amb_cosim.scenario.simulation import prepare, run_prepared

    prepared = prepare(load_scenario("fig4_9"), flavour="native")
    command = [sys.executable, "-m", "ziglang", "cc", "-std=gnu11", "-O1", f"-I{HEADERS}"]
    command += [str(TESTS / "native" / "support" / "co_simulation.c"), "-o", str(tmp_path / "host"), "-ldl"]
    subprocess.run(command, check=True, timeout=300)
    program, names = instructions(prepared)
    process = subprocess.run(
        [str(tmp_path / "host")], input=program, capture_output=True, text=True, timeout=300, check=False
    )
    assert process.returncode == 0, process.stderr[-2000:]
    table = np.array([[float.fromhex(word) for word in line.split()] for line in process.stdout.splitlines()])
    dataset = run_prepared(prepared).dataset
    assert len(table) == dataset.sizes["time"] > 1000
    for position, name in enumerate(names):
        np.testing.assert_array_equal(table[:, position], dataset[name].values.astype(float), err_msg=name)


def instructions(prepared: Any) -> tuple[str, list[str]]:
    """Return the program's input, and the names of the columns that it prints."""
    plan, interfaces = prepared.plan, prepared.interfaces
    wiring, inputs, outputs = plan.system.wiring(interfaces, list(plan.inputs), plan.recorded)
    head = f"components {len(plan.system.components)} first {plan.first} last {plan.last} step {plan.step_size!r}"
    lines = [f"{head} values {len(wiring.names)} exogenous {wiring.n_exogenous}"]
    position = wiring.n_exogenous
    for c, sources in zip(plan.system.components, wiring.sources, strict=True):
        ports, start = interfaces[c.name].ports, plan.parameters[c.name]
        library = prepared.fmus[c.name].folder / "binaries" / "linux64" / f"{interfaces[c.name].identifier}.so"
        count = f"every {c.every} parameters {len(start)} inputs {len(inputs[c.name])} outputs {len(outputs[c.name])}"
        resources = (prepared.fmus[c.name].folder / "resources").as_uri()
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
