"""Identification on the command line: the table that it writes, tables that it refuses, and their use in a run."""

import io
import itertools
import math
import zipfile
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from rich.table import Table
from rig import AXES, DONE, FAILED, SENSOR_NAMES, random_receptance
from rig import LOOP as RIG_LOOP

from amb_analysis.studies import receptance_measurement
from amb_analysis.studies.receptance_identification import HEADINGS
from amb_cosim import studies
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.model_constants.receptance_file import empty_table, loop_parameters, read_table
from amb_cosim.results.result import Result
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rolac_controller.enumerations import CONTACT_OCCURRED, NO_ERROR, WAITING
from rotor_analysis.packaged_rotors import rotor_path

LOOP = {f"{b}.{name}_{a}": value for b, a in AXES for name, value in (("k_s", 2e6), ("k_i", 563.0))}


@pytest.fixture
def table():
    """A table of the rig in the loop of the levitated system."""
    return (
        empty_table("bath_rig_thesis", RIG_LOOP, LOOP)
        .updated(60.0, random_receptance(3))
        .updated(100.0, random_receptance(4))
    )


def outputs(R: np.ndarray, state: int = DONE, error: int = NO_ERROR) -> xr.Dataset:
    """What a run records that ended so."""
    values = {"identification_state": state, "identification_error": error}
    for k, s in enumerate(SENSOR_NAMES):
        for i, (b, a) in enumerate(AXES):
            values |= {f"r.{s}.{b}_{a}.re": R[k, i].real, f"r.{s}.{b}_{a}.im": R[k, i].imag}
    return xr.Dataset({f"rolac_controller.{name}": ("time", [0.0, value]) for name, value in values.items()})


def completed(dataset: xr.Dataset) -> Result:
    """A run that reached its end."""
    return Result(dataset, Outcome("completed", 1.0))


@pytest.fixture
def runs(monkeypatch):
    """`runs(*results)`: the simulations of identify end with these results, one after the other."""

    def script(*results: Result) -> None:
        left = iter(results)
        monkeypatch.setattr(receptance_measurement, "execute", lambda prepared, progress: next(left))

    return script


@pytest.mark.slow
def test_speeds_that_succeed_are_kept_when_others_fail(runner, runs, tmp_path):
    ends = [
        completed(outputs(random_receptance(1))),
        completed(outputs(random_receptance(2), FAILED, CONTACT_OCCURRED)),
        completed(outputs(random_receptance(2), WAITING)),
        completed(outputs(np.zeros((8, 4)))),
        Result(xr.Dataset(), Outcome("failed", 1.0, "amb_actuator")),
        completed(outputs(random_receptance(6))),
    ]
    runs(*ends)
    result = runner("identify", "--speeds", "10 Hz,12 Hz,13 Hz,14 Hz,15 Hz,100 rad/s", "-o", "t.toml")
    assert result.exit_code == 1
    assert "identification failed at 4 of 6 speeds; t.toml contains the receptances at 2 speeds" in result.stderr
    lines = [line for line in result.stdout.splitlines() if line.strip()]
    words = ("done", "contact", "waiting for a valid window", "ill-conditioned", "amb_actuator failed", "done")
    for line, word in zip(lines[2:], words, strict=True):
        assert word in line
    retained = read_table(tmp_path / "t.toml", "bath_rig_thesis", RIG_LOOP, loop_parameters(RIG_LOOP, LOOP))
    assert [entry.speed for entry in retained.entries] == [2.0 * math.pi * 10.0, 100.0]
    np.testing.assert_array_equal(retained.entries[0].receptance, random_receptance(1))
    np.testing.assert_array_equal(retained.entries[1].receptance, random_receptance(6))


def test_a_new_identification_replaces_only_its_speed(runner, runs, table, tmp_path):
    table.write(tmp_path / "t.toml")
    runs(completed(outputs(random_receptance(8))))
    result = runner("identify", "--speeds", "100 rad/s", "-o", "t.toml")
    assert result.exit_code == 0, result.stderr
    retained = read_table(tmp_path / "t.toml").entries
    assert [entry.speed for entry in retained] == [60.0, 100.0]
    np.testing.assert_array_equal(retained[0].receptance, random_receptance(3))
    np.testing.assert_array_equal(retained[1].receptance, random_receptance(8))


def test_an_interrupt_keeps_the_speeds_before_it(runner, runs, tmp_path):
    runs(completed(outputs(random_receptance())), Result(xr.Dataset(), Outcome("interrupted", 2.0)))
    result = runner("identify", "--speeds", "10 Hz,20 Hz,30 Hz", "-o", "t.toml")
    assert result.exit_code == 130
    assert "amb-cosim: interrupted at t = 2 s; t.toml contains the receptances at 1 speed\n" in result.stderr
    assert [entry.speed for entry in read_table(tmp_path / "t.toml").entries] == [2.0 * math.pi * 10.0]


# Tables that are refused for the rig in the loop of the levitated system, and how.
WRONG = {
    "another rotor": (lambda t: replace(t, rotor="pump"), None, "it belongs to rotor 'pump', not 'bath_rig_thesis'"),
    "truncated": (lambda t: t, -400, "is not valid TOML"),
    "another loop": (
        lambda t: replace(t, parameters=loop_parameters(RIG_LOOP, LOOP | {"mb1.c_b_x": 3e3})),
        None,
        "mb1.c_b_x = 3000, not 5000; identify again",
    ),
    "another chain": (
        lambda t: replace(t, parameters=loop_parameters(RIG_LOOP, LOOP | {"chain.preset": 1.0})),
        None,
        "chain.preset = 1, not 0; identify again",
    ),
}


@pytest.mark.parametrize(
    ("command", "case"),
    [
        *itertools.product(["run fig5_6 --receptances", "identify --speeds 10Hz -o"], WRONG),
        *itertools.product(["build -o fmus --receptances"], ["another rotor", "truncated"]),
    ],
)
def test_tables_of_another_machine_are_refused_and_unchanged(refuses, table, tmp_path, command, case):
    change, cut, expected = WRONG[case]
    path = tmp_path / "t.toml"
    change(table).write(path)
    path.write_text(path.read_text(encoding="utf-8")[:cut], encoding="utf-8")
    before = path.read_bytes()
    assert "table of receptances t.toml" in refuses(expected, *command.split(), "t.toml")
    assert path.read_bytes() == before


def constants_of(fmu):
    with zipfile.ZipFile(fmu) as archive:
        return np.load(io.BytesIO(archive.read("resources/constants.npy")))


def test_paths_of_table_and_rotor_are_relative_to_the_scenario(table, tmp_path):
    """Also where another scenario, elsewhere, derives from it."""
    folder = tmp_path / "cases"
    folder.mkdir()
    text = rotor_path().read_text(encoding="utf-8")
    (folder / "mine.toml").write_text(text.replace('"bath_rig_thesis"', '"mine"'), encoding="utf-8")
    replace(table, rotor="mine").write(folder / "t.toml")
    (folder / "case.toml").write_text('base = "fig5_6"\nrotor = "mine.toml"\nreceptances = "t.toml"\n')
    (tmp_path / "derived.toml").write_text('base = "cases/case.toml"\nsettle_cycles = 3\n')
    for path in (folder / "case.toml", tmp_path / "derived.toml"):
        prepared = prepare_run(load_scenario(str(path)), options=RunOptions(flavour="python"))
        np.testing.assert_array_equal(constants_of(prepared.fmus["rolac_controller"].path), table.constants(RIG_LOOP))
    (folder / "case.toml").write_text('base = "fig5_6"\nreceptances = "t.toml"\n')
    with pytest.raises(ValueError, match="it belongs to rotor 'mine', not 'bath_rig_thesis'"):
        prepare_run(load_scenario(str(folder / "case.toml")))


@pytest.mark.slow
def test_an_identified_table_is_used_by_a_run(cosim, tmp_path):
    done = cosim("identify", "--speeds", "16 Hz,35 Hz", "-o", "t.toml", "--set", "rotor_contact.d1.u=3 g.m")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("done") == 2
    used = cosim("run", "fig5_6", "--receptances", "t.toml", "--until", "0.01", "--no-plots", "-o", "out")
    assert used.returncode == 0, used.stderr
    touching = cosim(
        "identify", "--speeds", "12 Hz", "-o", "t.toml", "--set", "rotor_contact.rb?.clearance=50 um"
    )  # fmt: skip
    assert touching.returncode == 1
    assert "contact" in touching.stdout
    assert len(read_table(tmp_path / "t.toml").entries) == 2


def test_computed_receptance_is_compared_with_nothing() -> None:
    """Its difference from the model from which it is computed is zero even if the model is wrong."""
    found = studies.identify("9000 rpm", scenario="compressor_levitated", computed=True, progress=False)
    (result,), (table,) = found.results, found.text()
    assert isinstance(table, Table)
    cells = dict(zip(("speed", *HEADINGS), (next(iter(column.cells)) for column in table.columns), strict=True))
    assert result.receptance is not None
    assert result.model is None
    assert (cells["differs from the model (%)"], cells[""]) == ("-", "computed, not compared")
