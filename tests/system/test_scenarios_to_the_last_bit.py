"""All scenarios of the packs, in both flavours: a continued run equals an uninterrupted one."""

import pytest

from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.execution import execute_plan
from amb_cosim.cosim.run.options import RunOptions, Saves
from amb_cosim.scenario.file import packaged_scenarios
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario

CYCLES = 15  # of a run at most
pytestmark = pytest.mark.slow


@pytest.mark.parametrize("flavour", ["native", "python"])
@pytest.mark.parametrize("name", packaged_scenarios())
def test_a_continued_scenario_has_the_same_bits(name, flavour, tmp_path):
    scenario, options = load_scenario(name), RunOptions(flavour=flavour)
    prepared, until = prepare_run(scenario, options=options), CYCLES * scenario.period
    if prepared.last * prepared.step_size > until:
        prepared = prepare_run(scenario, until=until, options=options)
    middle = prepared.last // 2
    plain = execute_plan(prepared, RunOptions(saves=Saves((0, middle))))
    for n, state in plain.checkpoints.items():
        start = Checkpoint.load(state.save(tmp_path / f"{n}.npz"))
        continued = execute_plan(prepared, RunOptions(start=start))
        assert continued.recorder.points.tobytes() == plain.recorder.points.tobytes()
        assert continued.recorder.table.tobytes() == plain.recorder.table.tobytes()
        assert continued.outcome == plain.outcome
