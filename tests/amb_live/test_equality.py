"""The rig is the run of the orchestrator, in node and in Chromium: the same machine code for another processor."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from live_answers import Answers

import amb_cosim

pytestmark = pytest.mark.slow  # the engine is compiled as WebAssembly first

SITES = ("rb1", "rb2", "eb1", "eb2")
DISPLACEMENTS = [*(f"rotor_contact.mb{k}.{axis}" for k in (1, 2) for axis in "xy")]
DISPLACEMENTS += [f"rotor_contact.s{k}" for k in range(1, 9)]
OTHERS = [
    *(f"rotor_contact.{site}.{name}" for site in SITES for name in ("mode", "f_n")),
    "rotor_contact.contact_state",
]
OTHERS += ["rotor_contact.theta", "rolac_controller.mb1.i_x", "amb_actuator.mb2.f_y", "rolac_controller.rolac_status"]
WATCHED = DISPLACEMENTS + OTHERS
CLEARANCE = 0.75e-3  # m, of the retainers

RUN_IN_WORKER = """
async ([watched, to]) => {
  const bytes = async (key) => new Uint8Array(await (await fetch(`rig/${key}`)).arrayBuffer());
  const rig = await (await fetch("rig/rig.json")).json(), parts = {}, answers = [];
  for (const key of [rig.module, rig.data]) { parts[key] = await bytes(key); }
  const worker = new Worker("page/worker.js", { type: "module" });
  const said = (request, isLast) => new Promise((resolve, reject) => {
    worker.onerror = ({ message }) => reject(new Error(message));
    worker.onmessage = ({ data }) => {
      answers.push(data);
      if (isLast(data)) { resolve(); }
    };
    worker.postMessage(request);
  });
  const isPaused = ({ type, status, point }) => type === "frame" && status === "paused" && point >= 0;
  await said({ type: "load", rig, parts, watched }, isPaused);
  await said({ type: "run", to }, isPaused);
  return JSON.stringify(answers, (_, value) => value instanceof Float64Array ? [...value] : value);
}
"""

Play = Callable[[str, float], Any]


@pytest.fixture
def in_node(session) -> Play:
    return lambda name, end: session(name, WATCHED, {"type": "run", "to": end})


@pytest.fixture
def in_chromium(chromium, serve, rig_folder, tmp_path) -> Play:
    (tmp_path / "index.html").write_text("<!doctype html><title>Run</title>", encoding="utf-8")
    (tmp_path / "page").symlink_to(Path(amb_cosim.live.__file__).parent / "page")

    def play(name: str, end: float) -> Answers:
        (tmp_path / "rig").symlink_to(rig_folder(name))
        page = chromium.new_page()
        page.goto(f"{serve(tmp_path)}/")
        return Answers(json.loads(page.evaluate(RUN_IN_WORKER, [WATCHED, end])))

    return play


def compare(name, play, record_property, capsys):
    native = amb_cosim.run(name, progress=False)
    dataset = native.dataset
    end = float(dataset["time"][-1])
    answers = play(name, end)
    (ended,) = answers.of("ended")
    assert (ended["reason"], ended["time"]) == (native.outcome.status, native.outcome.time)
    np.testing.assert_array_equal(answers.rows[:, 0], dataset["time"])
    for site in SITES:
        mode = f"rotor_contact.{site}.mode"
        np.testing.assert_array_equal(answers.column(mode), dataset[mode], err_msg=mode)
    touching = dataset["rotor_contact.contact_state"].values != 0
    first = int(np.argmax(touching)) if touching.any() else len(touching)
    apart = np.max([np.abs(answers.column(signal) - dataset[signal].values) for signal in DISPLACEMENTS], axis=0)
    before, largest = apart[:first].max(), apart.max()
    record_property("largest_difference_before_contact_m", float(before))
    record_property("largest_difference_m", float(largest))
    with capsys.disabled():
        print(f"\n{name}: displacements differ by {before:.1e} m before the first contact, by {largest:.1e} m in all")
    assert touching.any()
    assert before < 1e-9 * CLEARANCE
    assert largest < 1e-6 * CLEARANCE


@pytest.mark.host("node", "node", platform="WebAssembly", fmus="three of a scenario", what="this master's run")
@pytest.mark.parametrize("name", ["fig4_9", "fig5_6"])
def test_a_scenario_in_node_is_that_of_the_orchestrator(name, in_node, record_property, capsys):
    compare(name, in_node, record_property, capsys)


@pytest.mark.parametrize("name", ["fig4_9", "fig5_6"])
def test_a_scenario_in_chromium_is_that_of_the_orchestrator(name, in_chromium, record_property, capsys):
    compare(name, in_chromium, record_property, capsys)


@pytest.mark.parametrize("place", ["in_node", "in_chromium"])
def test_a_touchdown_is_that_of_the_orchestrator(place, request, record_property, capsys):
    compare("drop", request.getfixturevalue(place), record_property, capsys)
