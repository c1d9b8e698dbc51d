"""The command line: messages for bad input, and files that it writes."""

import io
import json
import re
import subprocess
import zipfile

import numpy as np
import pytest
from command_line import COMMAND
from rich.console import Console

from amb_cosim.commands import listing
from amb_cosim.commands.options import results_of
from amb_cosim.cosim.fmu.fmus import model_source
from amb_cosim.cosim.run.dataset import load
from amb_cosim.model_constants.plant_data import plant
from amb_cosim.presentation import plain_console
from amb_cosim.results.summary import summarise
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names


def test_list_describes_a_scenario_or_suggests_the_nearest(runner):
    text = runner("list", "compressor_touchdown").stdout
    assert all(word in text for word in ("theme", "rubs at its seal", "Timbo", "compressor_touchdown.toml"))
    assert "did you mean compressor_touchdown" in runner("list", "compressor_touchdow").stderr


def test_a_terminal_of_80_columns_shows_what_distinguishes_each_entry(monkeypatch):
    """Descriptions differ at their ends, which must not be cut; no two entries look the same."""
    text = io.StringIO()
    console = Console(file=text, width=80, force_terminal=True, color_system=None)
    monkeypatch.setattr(plain_console, "plain_console", lambda: console)
    listing.list_scenarios.callback(None, "")
    lines = text.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    words = " ".join(text.getvalue().split())
    entries = list(listing._entries())
    assert len(entries) > 50
    for entry in entries:
        assert f"{entry.name} {' '.join(entry.description.split())}" in words
    assert len({entry.description for entry in entries}) == len(entries)


def test_list_has_speeds_in_the_unit_of_summaries(runner):
    """260 rad/s in a file and 3 Hz in another; no description has a speed in another unit."""
    for name, speed in (("drop", "2483 rpm"), ("run_up", "180 to 1800 rpm")):
        text = runner("list", name).stdout
        assert speed in text
        assert "rad/s" not in text
    assert not re.search(r"\d (Hz|rad/s)", runner("list").stdout)


@pytest.mark.parametrize("arguments", [("list",), ("run", "fig4_9", "--until", "0.01", "--no-plots", "-o", "out")])
def test_a_closed_pipe_ends_a_command_silently(tmp_path, arguments):
    """As `head -1` closes the pipe; the record of a run is written before."""
    with subprocess.Popen(
        [*COMMAND, *arguments], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        process.stdout.close()
        errors = process.stderr.read().decode().splitlines()
    progress = ("waiting for another process", "simulating")  # which builds the FMUs; printed if a run takes long
    words = [line for line in errors if not line.startswith(progress)]
    assert (process.returncode, words) in [(0, []), (1, [])]
    assert arguments[0] == "list" or {file.name for file in (tmp_path / "out").iterdir()} == {
        "result.nc",
        "summary.json",
    }


def test_build_takes_a_rotor_file(runner, tmp_path):
    rig = rotor_path().read_text(encoding="utf-8")
    (tmp_path / "heavy.toml").write_text(rig.replace("mass = 10.0", "mass = 12.0"), encoding="utf-8")
    built = runner("build", "--flavour", "python", "--rotor", "heavy.toml", "-o", "heavy")
    assert built.exit_code == 0
    assert "An FMU of flavour python runs in a process that has Python with NumPy; a process without" in built.output
    assert_names(built.output, "only the rotor is from heavy.toml", "magnets, controller and gravity", "--scenario")

    def constants_of(name):
        with zipfile.ZipFile(tmp_path / "heavy" / f"{name}.fmu") as archive:
            return np.load(io.BytesIO(archive.read("resources/constants.npy")))

    np.testing.assert_array_equal(constants_of("rotor_contact"), plant(load_rotor(tmp_path / "heavy.toml"))[1])
    assert not np.array_equal(constants_of("rolac_controller"), model_source("rolac_controller")[1])


def test_a_run_writes_results_and_prints_the_summary(runner, tmp_path):
    done = runner("run", "fig4_9", "--until", "0.05", "--summary-json", "-")
    assert done.exit_code == 0, done.stderr
    figures = json.loads(done.stdout)
    folder = tmp_path / "results" / "fig4_9"
    assert "results/fig4_9" in done.stderr
    assert sorted(p.name for p in folder.iterdir()) == [
        "displacement.png",
        "magnets.png",
        "orbits.png",
        "result.nc",
        "summary.json",
    ]
    assert json.loads((folder / "summary.json").read_text()) == figures
    dataset = load(folder / "result.nc")
    assert summarise(dataset).as_dict() == figures
    assert figures["simulated_s"] == pytest.approx(0.05, rel=1e-12)
    assert dataset["time"].values[[0, -1]] == pytest.approx([0.0, 0.05])
    assert dataset["rotor_contact.mb1.x"].attrs["units"] == "m"
    assert dataset["Omega"].attrs["units"] == "rad/s"
    assert set(json.loads(dataset.attrs["fmu_guids"])) == {"rotor_contact", "amb_actuator", "rolac_controller"}
    assert json.loads(dataset.attrs["parameters"])["rotor_contact"]["rb1.clearance"] == 0.75e-3


@pytest.mark.parametrize("flavour", ["native", "python"])
def test_an_fmu_that_fails_to_start_ends_the_run_with_its_message(cosim, tmp_path, flavour):
    setting = "amb_actuator.mb1.bias_current_x=9 A"
    done = cosim("run", "fig4_9", "--until", "0.01", "--set", setting, "--flavour", flavour)
    assert done.returncode == 2
    assert "amb_actuator: fmi2ExitInitializationMode answered" in done.stderr
    assert done.stderr.count("mb1.bias_current_x = 9 A plus mb1.static_current_x = 1.14 A is not allowed") == 1
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_failing_step_keeps_the_record(runner, tmp_path):
    """Without control current the rotor falls into the magnet as soon as the retainer is wider than the air gap."""
    done = runner(
        "run", "fig4_9", "-o", "out", "--no-plots",
        "--set", "rotor_contact.rb?.clearance=5 mm",
        "--set", "rotor_contact.d1.u=0.2 kg.m",
        "--set", "amb_actuator.*.current_limit_?=5.58 A",
    )  # fmt: skip
    assert done.exit_code == 1
    assert "amb_actuator failed at t = " in done.stderr
    assert "the rotor must stay within the air gap" in done.stderr
    assert "Traceback" not in done.stderr
    dataset = load(tmp_path / "out" / "result.nc")
    assert dataset.attrs["completed"] == 0
    assert dataset.attrs["failure"].startswith("amb_actuator failed")
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["completed"] is False


def test_a_condition_of_the_scenario_ends_the_run_without_failure(runner, tmp_path):
    stop = '[[stop]]\nvariable = "rotor_contact.mb1.x"\nabove = "-1 mm"\nhold_time = "10 ms"\n'
    (tmp_path / "mine.toml").write_text('base = "fig4_9"\nsettle_cycles = 0\n' + stop)
    done = runner("run", "mine.toml", "-o", "out", "--no-plots")
    assert done.exit_code == 0, done.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["completed"] is True
    assert summary["stopped"] == "rotor_contact.mb1.x above -0.001 m for 0.01 s, at t = 0.01 s"
    assert summary["simulated_s"] == 0.01
    assert "stopped" in done.stdout
    dataset = load(tmp_path / "out" / "result.nc")
    assert dataset.attrs["stopped"] == summary["stopped"]
    assert dataset.sizes["time"] == 41


def test_landings_of_two_machines_do_not_overwrite_each_other(tmp_path, monkeypatch):
    (tmp_path / "pump").mkdir()
    monkeypatch.chdir(tmp_path)
    folders = {
        name: str(results_of(name)) for name in ("pump/landing.toml", "fan/landing.toml", "fig4_9", "./rub.toml")
    }
    assert [*folders.values()] == [f"results/{name}" for name in ("pump_landing", "fan_landing", "fig4_9", "rub")]
    monkeypatch.chdir(tmp_path / "pump")
    assert results_of("../pump/landing.toml") == results_of(tmp_path / "pump" / "landing.toml")
    assert results_of("../landing.toml").name == f"{tmp_path.name}_landing"
