"""Progress of commands: a bar in a terminal, lines elsewhere."""

from itertools import count
from time import sleep
from types import SimpleNamespace

import click
import pytest
from click.testing import CliRunner

import source_check.evaluation
from amb_analysis import studies
from amb_assessment.assessment.engine import assess
from amb_assessment.first_design import files
from amb_cosim.commands.cli import main
from amb_cosim.presentation import progress
from amb_sweeps.sweep_bar import sweep_bar


@pytest.fixture
def quiet():
    """In place of the fixture of all tests: here commands print lines as they do for users."""


def clock(monkeypatch, times):
    """Replace the clock of progress by a series of times (s)."""
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=iter(times).__next__))


def lines_of(*arguments):
    """Return the lines on standard error of a command that ends early."""
    ended = CliRunner().invoke(main, arguments)
    assert "ended here" in ended.stderr
    return [line.strip() for line in ended.stderr.splitlines() if "ended here" not in line]


@click.command()
def simulating():
    """Report each tenth of ten runs."""
    with progress.progress_bar() as report:
        for done in range(1, 6):
            report(done, 10)


PARTS = {"free_modes": "Free modes", "critical_map": "Critical speeds"}


def test_each_part_prints_one_line_without_a_terminal(monkeypatch, tmp_path):
    def answered(name, *_):
        if name == "critical_map":
            raise ValueError("ended here")

    parts = {name: assess.Analysis(title, answered) for name, title in PARTS.items()}
    monkeypatch.setattr(assess, "ANALYSES", parts)
    monkeypatch.setattr(assess, "_answered", answered)
    lines = lines_of("assess", "compressor", "-o", str(tmp_path / "page"))
    assert lines == ["1 of 2: Free modes", "2 of 2: Critical speeds"]


def test_a_piped_command_prints_at_most_a_line_in_ten_seconds(monkeypatch):
    """Of reports at 4, 11, 15, 20 and 21 s, those at 11 and 21 s follow the previous line by ten seconds."""
    clock(monkeypatch, [0.0, 4.0, 11.0, 11.0, 15.0, 20.0, 21.0, 21.0])
    ended = CliRunner().invoke(simulating)
    assert ended.stdout == ""
    assert ended.stderr.splitlines() == ["simulating, 20 %", "simulating, 50 %"]


def test_a_piped_command_says_that_its_first_step_compiles(monkeypatch):
    """It takes minutes in a new environment, and reports nothing."""

    @click.command()
    def compiling():
        with progress.progress_bar() as report:
            sleep(0.1)
            report(1, 10)
            sleep(0.1)

    monkeypatch.setattr(progress.bars, "__defaults__", (None, 0.04))
    lines = CliRunner().invoke(compiling).stderr.splitlines()
    starting = [line for line in lines if line.startswith(progress.STARTING)]
    assert starting  # how many depends on the machine
    assert lines[len(starting) :] == ["simulating, 10 %"]


def test_a_piped_study_that_takes_longer_than_the_patience_says_that_it_computes(monkeypatch, tmp_path):
    """Two seconds by default, and nothing before: a spinner alone is invisible in a log."""
    assert progress.PATIENCE == 2.0

    def computing(**_):
        sleep(0.2)
        raise ValueError("ended here")

    for name in ("campbell", "poles", "traps", "fit", "sensitivity"):
        monkeypatch.setattr(studies, name, computing, raising=False)
        monkeypatch.setattr(progress, "PATIENCE", 0.05)
        first, *_ = lines_of("study", name, "-o", str(tmp_path / name))
        assert first.startswith(progress.COMPUTING)
        monkeypatch.setattr(progress, "PATIENCE", 60.0)
        assert lines_of("study", name, "-o", str(tmp_path / name)) == []


def test_a_run_from_python_prints_no_line(monkeypatch, capfd):
    clock(monkeypatch, count(step=20.0))
    simulating.callback()
    assert capfd.readouterr() == ("", "")


def test_a_command_whose_progress_is_off_prints_no_line(monkeypatch):
    @click.command()
    def silent():
        with progress.progress_bar(False) as report:
            report(1, 10)

    clock(monkeypatch, count(step=20.0))
    assert CliRunner().invoke(silent).stderr == ""


def test_a_piped_sweep_prints_how_many_runs_have_ended(monkeypatch):
    @click.command()
    def sweeping():
        with sweep_bar() as report:
            report(3, 12, "")

    clock(monkeypatch, count(step=20.0))
    assert "3 of 12 runs" in CliRunner().invoke(sweeping).stderr


SHAFT = ("--mass", "60 kg", "--length", "1.2 m", "--speed", "12000 rpm")


@pytest.mark.parametrize(
    ("module", "function", "done", "command", "line"),
    [
        (files, "first_design", (50e-6, 24), ("new", "pump", *SHAFT), "sample time 50 µs, gains tried: 24"),
        (source_check.evaluation, "assess", (7, 80), ("report", "--pack", "bath_thesis"), "7 of 80 runs and studies"),
    ],
)
def test_a_piped_command_prints_the_work_done(monkeypatch, tmp_path, module, function, done, command, line):
    def answer(*arguments, **options):
        *_, progress = (argument for argument in (*arguments, *options.values()) if callable(argument))
        progress(*done)
        raise ValueError("ended here")

    monkeypatch.setattr(module, function, answer)
    monkeypatch.chdir(tmp_path)
    clock(monkeypatch, count(step=20.0))
    assert lines_of(*command) == [line]
