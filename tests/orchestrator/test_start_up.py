"""Modules loaded by imports and commands: importing a heavy package takes longer than a run."""

import json
import sys

import pytest
from command_line import run_program

HEAVY = ("control", "llvmlite", "matplotlib", "numba", "pandas", "pint", "pythonfmu", "scipy", "xarray")
OWN = (
    "amb_actuator",
    "linear_controller",
    "rolac_controller",
    "rotor_analysis",
    "rotor_contact",
)  # the models and what computes constants
APPLICATIONS = ("amb_analysis", "amb_assessment", "amb_live", "amb_sweeps")
ALL = ("fmpy", "h5py", "numpy", "pydantic", "rich", *HEAVY, *OWN)
RUN = ("run", "fig4_9", "-o", "out", "--until")
HELPED = (("run",), ("build",), ("identify",), ("study",), ("study", "campbell"))

LOADED = """
import importlib, json, sys
names, modules, commands = map(json.loads, sys.argv[1:])
for module in modules:
    importlib.import_module(module)
for arguments in commands:
    from amb_cosim.commands.cli import main
    main(arguments, standalone_mode=False)
print(*(name for name in names if name in sys.modules), file=sys.stderr)
"""


@pytest.fixture
def loaded(tmp_path):
    """`loaded(names, modules, *commands)`: those of the packages that imports, then commands load in a process."""

    def load(names, modules=(), *commands):
        texts = map(json.dumps, (names, modules, commands))
        done = run_program(sys.executable, "-c", LOADED, *texts, cwd=tmp_path)
        return done.stderr.splitlines()[-1].split()

    return load


def test_import_and_help_load_no_numerical_package(loaded):
    helps = ([*command, "--help"] for command in HELPED)
    assert loaded(ALL, ("amb_cosim", "amb_analysis.studies"), *helps) == []


def test_figures_load_matplotlib_when_they_are_drawn(loaded):
    assert loaded(("control", "matplotlib"), ("amb_cosim.results.plots",)) == []


def test_a_run_loads_no_compiler_model_data_set_or_application(loaded, runner, tmp_path):
    run = (*RUN, "0.01", "--no-plots", "--set", "rotor_contact.rb1.clearance=0.6 mm")
    assert runner(*run).exit_code == 0  # a first run may build what is not there yet
    assert loaded((*HEAVY, *OWN, *APPLICATIONS), ("amb_cosim",), run) == []
    assert (tmp_path / "out" / "result.nc").is_file()


def test_pole_areas_load_no_library_of_units(loaded, runner):
    run = (*RUN, "0.01", "--no-plots", "--set", "amb_actuator.*.pole_area_?=4 cm^2")
    assert runner(*run).exit_code == 0
    assert loaded(("pint",), (), run) == []


@pytest.mark.slow
def test_figures_are_drawn_by_matplotlib_alone(loaded, runner, tmp_path):
    run = (*RUN, "0.3")
    assert runner(*run).exit_code == 0
    assert loaded((*HEAVY, *OWN), (), run) == ["matplotlib"]
    assert (tmp_path / "out" / "orbits.png").is_file()
