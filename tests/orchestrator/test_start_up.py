"""What a command loads: the import of one heavy package takes longer than a run."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("control", "llvmlite", "matplotlib", "numba", "pandas", "pint", "pythonfmu", "scipy", "xarray")
OWN = ("amb_actuator", "rolac_controller", "rotor_analysis", "rotor_contact")  # the models and what computes constants
ALL = ("fmpy", "h5py", "numpy", "pydantic", "rich", *HEAVY, *OWN)

LOADED = """
import sys
from amb_cosim.commands.cli import main
main(sys.argv[2:], standalone_mode=False)
print(*(name for name in sys.argv[1].split() if name in sys.modules), file=sys.stderr)
"""


@pytest.fixture
def loaded(tmp_path):
    """`loaded(names, *arguments)`: those of the packages that a command in a process of its own loads."""

    def load(names, *arguments):
        command = [sys.executable, "-c", LOADED, " ".join(names), *arguments]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        return done.stderr.splitlines()[-1].split()

    return load


@pytest.mark.parametrize("command", ["run", "build", "identify", "study", "study campbell"])
def test_help_loads_nothing_to_compute_with(loaded, command):
    assert loaded(ALL, *command.split(), "--help") == []


def test_a_run_loads_neither_compiler_nor_model_nor_data_set(loaded, tmp_path):
    run = ("run", "fig4_9", "--until", "0.01", "--no-plots", "-o", "out", "--set", "rotor_contact.rb1.clearance=0.6 mm")
    loaded((), *run)  # a first run may build what is not there yet
    assert loaded((*HEAVY, *OWN), *run) == []
    assert (tmp_path / "out" / "result.nc").is_file()


@pytest.mark.slow
def test_figures_are_drawn_by_matplotlib_alone(loaded, tmp_path):
    run = ("run", "fig4_9", "--until", "0.3", "-o", "out")
    loaded((), *run)
    assert loaded((*HEAVY, *OWN), *run) == ["matplotlib"]
    assert (tmp_path / "out" / "orbits.png").is_file()
