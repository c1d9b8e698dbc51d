"""The tutorial on a rotor of one's own: its files and commands do what they say."""

import re
from pathlib import Path

import pytest

from amb_cosim.results.result import Result

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "own_rotor.md"
BLOCKS = re.findall(r"```(toml|sh)\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
COMMANDS = [line for kind, text in BLOCKS if kind == "sh" for line in text.splitlines()]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The files of the page, each named in its first line."""
    for kind, text in BLOCKS:
        if kind == "toml":
            (tmp_path / text.split()[1]).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(runner, line):
    name, *arguments = [part.strip('"') for part in re.findall(r'"[^"]*"|\S+', line)]
    assert name == "amb-cosim"
    done = runner(*arguments)
    assert done.exit_code == 0, done.output
    return done


@pytest.mark.slow
@pytest.mark.parametrize("line", [c for c in COMMANDS if " run " not in c and " build " not in c])
def test_commands_that_look_at_the_rotor_work(runner, folder, line):
    assert "pump" in run(runner, line).output or list(folder.glob("results/*/*.png"))


def test_the_pump_rubs_on_its_ring_and_recovers(runner, folder):
    run(runner, next(c for c in COMMANDS if " run " in c))
    summary = Result.load(folder / "results" / "pump_rub").summary
    assert summary.peak_contact_force["ring"] > 100.0
    assert summary.recovery == "recovered"
    assert summary.energy_balance < 1e-6
    assert len(list((folder / "results" / "pump_rub").glob("*.png"))) == 3


@pytest.mark.slow
def test_three_fmus_are_built_of_the_pump(runner, folder):
    run(runner, next(c for c in COMMANDS if " build " in c))
    assert {file.stem for file in folder.glob("fmus/*.fmu")} == {"rotor_contact", "amb_actuator", "rolac_controller"}
