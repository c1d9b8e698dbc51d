"""All scenarios of the packs, of both flavours, continued from a saved state."""

from __future__ import annotations

import pytest

from amb_cosim.cosim.checkpoint import Checkpoint
from amb_cosim.cosim.saving import Saves
from amb_cosim.scenario.file import packaged_scenarios
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import prepare, record_prepared

CYCLES = 15  # of a run at most


@pytest.mark.slow
@pytest.mark.parametrize("flavour", ["native", "python"])
@pytest.mark.parametrize("name", packaged_scenarios())
def test_a_continued_scenario_has_the_same_bits(name, flavour, tmp_path):
    scenario = load_scenario(name)
    prepared = prepare(scenario, flavour=flavour)
    if prepared.plan.last * prepared.plan.step_size > CYCLES * scenario.period:
        prepared = prepare(scenario, until=CYCLES * scenario.period, flavour=flavour)
    middle = prepared.plan.last // 2
    plain = record_prepared(prepared, saves=Saves((0, middle)))
    for n, state in plain.checkpoints.items():
        start = Checkpoint.load(state.save(tmp_path / f"{n}.npz"))
        continued = record_prepared(prepared, start=start)
        assert continued.recorder.points.tobytes() == plain.recorder.points.tobytes()
        assert continued.recorder.table.tobytes() == plain.recorder.table.tobytes()
        assert continued.outcome == plain.outcome
