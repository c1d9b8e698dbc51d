"""Rotors of ROSS 3.1: coefficients over the spin speed are read, those over the whirl frequency need a frequency.

Magnetic bearings become magnets and a controller file, whose sampled closed loop has ROSS's modes.

`tools/ross/ross31_rotors.py` renews the files and ROSS's numbers.
"""

import json
import math
import re

import numpy as np
import pytest
from click.testing import CliRunner
from ross_numbers import REFERENCE, complex_numbers, nearest

import amb_cosim
from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.linear.loop import Loop
from amb_analysis.studies.loop_vibrations import vibrations
from amb_cosim.commands.cli import main
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from amb_files.toml import validate
from rotor_analysis.ross_file import read_ross
from rotor_analysis.rotor import Rotor
from rotor_analysis.spectrum import eigenvalues
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import assert_names, raises_naming

FOLDER = REFERENCE / "ross31"
RESULTS = json.loads((FOLDER / "results.json").read_text(encoding="utf-8"))
TORSION = 1e-6  # rad/s of decay that a bending mode has more of


def modes_of_ross(name, kind):
    """At each speed, without torsional modes, which these bearings do not damp."""
    return {
        float(speed): [pair for pair in complex_numbers(pairs) if abs(pair.real) > TORSION]
        for speed, pairs in RESULTS[name][kind].items()
    }


def nearest_modes(rotor, speed, theirs):
    return nearest(eigenvalues(supported_rotor(rotor).model, speed), np.array(theirs))


def test_coefficients_over_the_spin_speed_match_ross():
    rotor = validate(read_ross(FOLDER / "over_speed.toml")[0], Rotor, "over_speed")
    for speed, theirs in modes_of_ross("over_speed", "at_speed").items():
        np.testing.assert_allclose(nearest_modes(rotor, speed, theirs), theirs, rtol=1e-6)


@pytest.mark.parametrize("name", ["over_frequency", "magnets"])
def test_a_mode_with_coefficients_of_its_frequency_is_the_matched_one(name):
    count = 0
    for speed, theirs in modes_of_ross(name, "matched").items():
        for mode in theirs:
            content, notes, _ = read_ross(FOLDER / f"{name}.toml", mode.imag)
            assert any(f"whirl frequency {mode.imag:.6g} rad/s" in note for note in notes)
            rotor = validate(content, Rotor, name)
            assert {bearing.whirl_frequency for bearing in rotor.bearings} == {mode.imag}
            ours = nearest_modes(rotor, speed, [mode])
            np.testing.assert_allclose(ours, [mode], rtol=1e-4)  # ROSS iterates no further
            count += 1
    assert count > 8


def test_coefficients_over_whirl_frequency_require_a_frequency():
    with raises_naming(ValueError, "`frequency`", "whirl"):
        read_ross(FOLDER / "over_frequency.toml")


@pytest.mark.parametrize("name", ["magnets", "integral"])
def test_modes_with_imported_magnets_and_controller_match_ross(tmp_path, monkeypatch, name):
    """But for the hold of the sampled controller, whose delay falls with the sample time."""
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, ["rotor", "import", str(FOLDER / f"{name}.toml")])
    assert done.exit_code == 0, done.output
    assert done.stdout.split() == [f"{name}_{part}.toml" for part in ("rotor", "controller", "levitation")]
    deviations = []
    for sample_time in ("20 us", "2 us"):
        for part in ("controller", "levitation"):
            file = tmp_path / f"{name}_{part}.toml"
            file.write_text(file.read_text().replace("20 us", sample_time))
        prepared = prepare_run(as_scenario(file, None).machine())
        loop = Loop(source_of_run(prepared))
        deviations.append(
            max(
                np.min(np.abs(vibrations(loop, speed).poles / mode - 1.0))
                for speed, theirs in modes_of_ross(name, "matched").items()
                for mode in theirs
            )
        )
    assert deviations[0] < 2e-4
    assert deviations[1] < 3e-5


def test_a_magnet_whose_table_was_changed_needs_a_frequency(tmp_path):
    """ROSS reads the saved coefficients, regardless of the magnet's data beside them."""
    saved = (FOLDER / "magnets.toml").read_text()
    (tmp_path / "changed.toml").write_text(saved.replace("ki_pid = 0", "ki_pid = 1e5", 1))
    with raises_naming(ValueError, "`frequency`", "magnet0"):
        read_ross(tmp_path / "changed.toml")


def test_sensors_beside_a_magnet_are_reported_since_ross_ignores_them(tmp_path):
    """ROSS feeds back the motion of the magnet's node; the imported scenario that of the sensors."""
    saved = (FOLDER / "magnets.toml").read_text()
    assert not [note for note in read_ross(FOLDER / "magnets.toml")[1] if "sensors" in note]
    old = re.search(r"sensor_node = (\d+)", saved)
    (tmp_path / "moved.toml").write_text(saved.replace(old[0], f"sensor_node = {int(old[1]) + 1}", 1))
    (note,) = [note for note in read_ross(tmp_path / "moved.toml")[1] if "sensors" in note]
    assert_names(note, f"node {int(old[1]) + 2}", f"node {int(old[1]) + 1}", "ROSS")


def test_an_imported_rotor_levitates_in_its_magnets(tmp_path):
    """After a pulse of unbalance it returns to rest; with a wrong sign of control or K_s it would not levitate."""
    rotor = tmp_path / "integral_rotor.toml"
    done = CliRunner().invoke(main, ["rotor", "import", str(FOLDER / "integral.toml"), "-o", str(rotor)])
    assert done.exit_code == 0, done.output
    inputs = {"rotor_contact.disk_0.u": "20 g.mm"}
    result = amb_cosim.run(tmp_path / "integral_levitation.toml", set=inputs, until="0.3 s", progress=False)
    orbit = np.hypot(result.dataset["rotor_contact.magnet0_probe.x"], result.dataset["rotor_contact.magnet0_probe.y"])
    assert 1e-9 < float(orbit.max()) < 2e-6


def test_a_frequency_beyond_the_table_is_refused():
    with raises_naming(ValueError, "900 rad/s", "bearing0", "0 to 800"):
        read_ross(FOLDER / "over_frequency.toml", 900.0)


def test_the_command_takes_the_frequency_with_its_unit(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = ["rotor", "import", str(FOLDER / "over_frequency.toml")]
    refused = CliRunner().invoke(main, command)
    assert refused.exit_code == 2
    assert "--frequency" in refused.stderr
    done = CliRunner().invoke(main, [*command, "--frequency", f"{200.0 / math.tau} Hz"])
    assert done.exit_code == 0, done.output
    assert "200 rad/s (31.83 Hz)" in (tmp_path / "over_frequency_rotor.toml").read_text()
