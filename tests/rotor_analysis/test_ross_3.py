"""Rotors of ROSS 3.1: coefficients over the spin speed are read, those over the whirl frequency need a frequency.

`tests/reference/ross31_rotors.py` renews the files and ROSS's numbers.
"""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner
from ross_numbers import REFERENCE, complex_numbers, nearest

from amb_cosim.commands.cli import main
from amb_files.toml import validate
from rotor_analysis.modes import eigenvalues
from rotor_analysis.ross_file import read_ross
from rotor_analysis.rotor import Rotor
from rotor_analysis.supported_rotor import supported_rotor

FOLDER = REFERENCE / "ross31"
RESULTS = json.loads((FOLDER / "results.json").read_text(encoding="utf-8"))
TORSION = 1e-6  # rad/s of decay that a bending mode has more of


def modes_of_ross(name, kind):
    """By speed, without the torsional ones, which these bearings leave undamped."""
    return {
        float(speed): [pair for pair in complex_numbers(pairs) if abs(pair.real) > TORSION]
        for speed, pairs in RESULTS[name][kind].items()
    }


def nearest_modes(rotor, speed, theirs):
    return nearest(eigenvalues(supported_rotor(rotor).model, speed), np.array(theirs))


def test_coefficients_over_the_spin_speed_are_those_of_ross():
    rotor = validate(read_ross(FOLDER / "over_speed.toml")[0], Rotor, "over_speed")
    for speed, theirs in modes_of_ross("over_speed", "at_speed").items():
        np.testing.assert_allclose(nearest_modes(rotor, speed, theirs), theirs, rtol=1e-6)


@pytest.mark.parametrize("name", ["over_frequency", "magnets"])
def test_a_mode_frozen_at_its_own_frequency_is_the_matched_one(name):
    count = 0
    for speed, theirs in modes_of_ross(name, "matched").items():
        for mode in theirs:
            content, notes = read_ross(FOLDER / f"{name}.toml", mode.imag)
            assert any("its coefficients over the whirl frequency are those at" in note for note in notes)
            ours = nearest_modes(validate(content, Rotor, name), speed, [mode])
            np.testing.assert_allclose(ours, [mode], rtol=1e-4)  # ROSS iterates no further
            count += 1
    assert count > 8


@pytest.mark.parametrize("name", ["over_frequency", "magnets"])
def test_coefficients_over_the_whirl_frequency_are_refused_without_one(name):
    with pytest.raises(ValueError, match="over the whirl frequency, which --frequency freezes at one value"):
        read_ross(FOLDER / f"{name}.toml")


def test_a_frequency_beyond_the_table_is_refused():
    with pytest.raises(ValueError, match=r"frequency = 900 rad/s is not allowed; bearing0 has those from 0 to 800"):
        read_ross(FOLDER / "over_frequency.toml", 900.0)


def test_the_command_takes_the_frequency_with_its_unit(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = ["rotor", "import", str(FOLDER / "over_frequency.toml")]
    refused = CliRunner().invoke(main, command)
    assert refused.exit_code == 2
    assert "--frequency" in refused.stderr
    done = CliRunner().invoke(main, [*command, "--frequency", f"{200.0 / math.tau} Hz"])
    assert done.exit_code == 0, done.output
    assert "those at 200 rad/s (31.83 Hz)" in (tmp_path / "over_frequency_rotor.toml").read_text()
