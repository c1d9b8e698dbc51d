"""All scenarios of the packs, of both flavours: continued and branched they are what they are alone."""

from __future__ import annotations

import zlib

import pytest

from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.options import RunOptions, Saves
from amb_cosim.cosim.run.run_plan import run_plan
from amb_cosim.scenario.file import packaged_scenarios
from amb_cosim.scenario.plan_run import plan_run
from amb_cosim.scenario.scenario import load_scenario
from amb_sweeps.worker import Runner, Task

CYCLES, FEW_CYCLES = 15, 7  # of a run at most; the first events come before the sixth
FLAVOURS = pytest.mark.parametrize("flavour", ["native", "python"])
pytestmark = pytest.mark.slow


def first_label(name):
    """Return the label of the first event that has one."""
    return next((event.label for event in load_scenario(name).event if event.label), None)


def shortened(name):
    """Return a scenario that settles for a cycle at most."""
    scenario = load_scenario(name)
    return scenario.changed(settle_cycles=min(scenario.settle_cycles, 1.0))


def planned_for(scenario, cycles, flavour):
    planned, until = plan_run(scenario, options=RunOptions(flavour=flavour)), cycles * scenario.period
    if planned.plan.last * planned.plan.step_size > until:
        planned = plan_run(scenario, until=until, options=RunOptions(flavour=flavour))
    return planned


@FLAVOURS
@pytest.mark.parametrize("name", packaged_scenarios())
def test_a_continued_scenario_has_the_same_bits(name, flavour, tmp_path):
    planned = planned_for(load_scenario(name), CYCLES, flavour)
    middle = planned.plan.last // 2
    plain = run_plan(planned.assembly, planned.plan, RunOptions(saves=Saves((0, middle))))
    for n, state in plain.checkpoints.items():
        start = Checkpoint.load(state.save(tmp_path / f"{n}.npz"))
        continued = run_plan(planned.assembly, planned.plan, RunOptions(start=start))
        assert continued.recorder.points.tobytes() == plain.recorder.points.tobytes()
        assert continued.recorder.table.tobytes() == plain.recorder.table.tobytes()
        assert continued.outcome == plain.outcome


def bits(result):
    """Return a number that tells the bits of all signals of a run."""
    return {
        "bits": float(zlib.crc32(b"".join(matches.values.tobytes() for matches in result.signals.variables.values())))
    }


@FLAVOURS
@pytest.mark.parametrize("name", [name for name in packaged_scenarios() if first_label(name)])
def test_points_that_share_a_past_have_the_bits_of_a_scenario(name, flavour):
    scenario, label = shortened(name), first_label(name)
    event = next(event for event in scenario.event if event.label == label)
    if event.cycle is not None:
        points = [{f"{label}.cycle": event.cycle + late} for late in (0.0, 0.5)]
    else:
        points = [{f"{label}.time": late * scenario.period} for late in (0.5, 1.0)]
    matches, shared = [], []
    for labels in ((), (label,)):
        task = Task(
            scenario,
            until=FEW_CYCLES * scenario.period,
            options=RunOptions(flavour=flavour),
            metrics=(bits,),
            labels=labels,
        )
        runner = Runner(task)
        results = [runner.run(n, settings) for n, settings in enumerate(points)]
        runner.close()
        shared.append([result.metrics.get("shared", 0.0) for result in results])
        matches.append([(result.outcome, result.reason, result.metrics.get("bits")) for result in results])
    assert matches[0] == matches[1]
    assert None not in (matches[0][0][2], matches[0][1][2]), matches
    assert matches[0][0][2] != matches[0][1][2], "the points differ"
    assert shared[0] == [0.0, 0.0]
    assert shared[1][0] == 0.0 < shared[1][1]
