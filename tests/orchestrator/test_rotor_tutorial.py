"""The tutorial on a rotor of one's own: its run ends as the page says; its code runs in `tests/docs`."""

import re
from pathlib import Path

import pytest

from amb_cosim.results.result import Result

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "own_rotor.md"
BLOCKS = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.slow
def test_the_pump_rubs_on_its_ring_and_recovers(runner, tmp_path):
    for text in BLOCKS:
        (tmp_path / text.split()[1]).write_text(text, encoding="utf-8")
    done = runner("run", "pump_rub.toml")
    assert done.exit_code == 0, done.output
    summary = Result.load(tmp_path / "results" / "pump_rub").summary
    assert summary.peak_contact_force["ring"] > 100.0
    assert summary.recovery == "recovered"
    assert summary.energy_balance < 1e-6
    assert len(list((tmp_path / "results" / "pump_rub").glob("*.png"))) == 3
