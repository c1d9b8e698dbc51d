"""Building blocks of the orchestrator's tests."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner, Result
from command_line import run_command
from matplotlib.image import imread

from amb_cosim.commands.cli import main
from amb_cosim.presentation.progress import COMPUTING, STARTING
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.stored_attributes import UNITS

PERIOD = 0.02
SAMPLES = 100  # per cycle
CLEARANCE, JOURNAL = 0.75e-3, 0.025
PLACES = RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2", "eb1", "eb2"), magnetic=("mb1", "mb2"))


@pytest.fixture
def cosim(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Run `amb-cosim` in a separate process and an empty folder, so that two runs do not share Python FMUs."""

    return lambda *arguments: run_command(*arguments, cwd=tmp_path, code=None)


def make_run(end: float = 20, **attributes) -> xr.Dataset:
    """Return a run whose key values are known.

    Orbits of 0.1 and 0.2 mm, 0.5 and 0.6 mm from the step at cycle 5 to its removal at 10, 0.3 and 0.4 mm after.
    Contact: RB1 in cycles 6 to 7, both in 7 to 7.5, RB2 in 11 to 12. The loop is stable.
    """
    k = np.arange(round(end * SAMPLES) + 1)
    cycle = k / SAMPLES
    loaded, after = (k >= 500) & (k < 1000), k >= 1000
    radius = {
        "mb1": np.select([loaded, after], [0.5e-3, 0.3e-3], 0.1e-3),
        "mb2": np.select([loaded, after], [0.6e-3, 0.4e-3], 0.2e-3),
    }
    state = np.select([(k >= 600) & (k < 700), (k >= 700) & (k < 750), (k >= 1100) & (k < 1200)], [1, 3, 2], 0)
    variables: dict[str, np.ndarray] = {"contact_state": state.astype(np.int32)}
    for mb, r in radius.items():
        variables[f"{mb}.x"] = r * np.cos(2 * np.pi * cycle)
        variables[f"{mb}.y"] = r * np.sin(2 * np.pi * cycle)
    variables["rb1.f_n"] = np.select([k == 650, np.isin(state, (1, 3))], [1234.5, 1000.0], 0.0)
    variables["rb2.f_n"] = np.where(np.isin(state, (2, 3)), 700.0, 0.0)
    variables["rb1.impulse"] = np.where(k == 600, 2.5, 0.0)
    variables["rb2.impulse"] = np.where(k == 700, 1.5, 0.0)
    for site, states in (("rb1", (1, 3)), ("rb2", (2, 3))):
        variables[f"{site}.mode"] = np.isin(state, states).astype(np.int32)
        variables[f"{site}.whirl_speed"] = np.full(len(k), 2 * np.pi / PERIOD)
    for site in ("eb1", "eb2"):
        variables[f"{site}.f_n"] = variables[f"{site}.impulse"] = variables[f"{site}.mode"] = np.zeros(len(k))
    for name in ("kinetic", "strain", "damping", "friction", "impact", "work", "balance"):
        variables[f"energy.{name}"] = np.zeros(len(k))
    sites = {f"rb{i}.{name}": value for i in (1, 2) for name, value in _SITE.items()}
    return xr.Dataset(
        {
            f"rotor_contact.{name}": (
                "time",
                values,
                {"units": UNITS.get(name.rpartition(".")[2], "1"), "description": name, "causality": "output"},
            )
            for name, values in variables.items()
        },
        {"time": ("time", cycle * PERIOD, {"units": "s"}), "cycle": ("time", cycle, {"units": "1"})},
        {
            "scenario": "synthetic",
            "flavour": "python",
            "completed": 1,
            "settling_s": 0.8,
            "simulated_s": end * PERIOD,
            "wall_s": 0.1,
            "speed_rad_s": 2 * np.pi / PERIOD,
            "places": PLACES.to_json(),
            "period_s": PERIOD,
            "disturbance_cycle": 5.0,
            "relief_cycle": 10.0,
            "disturbance_label": "step",
            "relief_label": "removal",
            "parameters": json.dumps({"rotor_contact": sites}),
            "loop_stability": LoopStability(0.99, -100.0, 200.0).to_json(),
            **attributes,
        },
    )


def acting(dataset: xr.Dataset, begin: float) -> xr.Dataset:
    """Let ROLAC act from a cycle on."""
    dataset["rolac_controller.rolac_active"] = ("time", (dataset["cycle"].values >= begin).astype(np.int8))
    return dataset


_SITE = {"clearance": CLEARANCE, "journal_radius": JOURNAL}


@pytest.fixture(scope="session")
def synthetic() -> Callable[..., xr.Dataset]:
    """`synthetic(end=20, **attributes)`: a run of `end` cycles whose figures are known, see `make_run`."""
    return make_run


@pytest.fixture
def without() -> Callable[..., xr.Dataset]:
    """`without(dataset, *attributes)`: a copy that lacks these attributes."""

    def strip(dataset: xr.Dataset, *attributes: str) -> xr.Dataset:
        stripped = dataset.copy()
        stripped.attrs = {name: value for name, value in dataset.attrs.items() if name not in attributes}
        return stripped

    return strip


@pytest.fixture
def runner(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """`runner(*arguments)`: result of the command line, in a separate folder."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> Result:
        return CliRunner().invoke(main, list(arguments))

    return call


@pytest.fixture
def refuses(runner, tmp_path: Path) -> Callable[..., str]:
    """`refuses(expected, *arguments)`: the message of exit code 2, with `expected` in it, and nothing is written."""

    def check(expected: str, *arguments: str) -> str:
        before = sorted(path.name for path in tmp_path.iterdir())
        result = runner(*arguments)
        assert result.exit_code == 2
        assert isinstance(result.exception, SystemExit)
        assert expected in result.stderr
        lines = [line for line in result.stderr.strip().splitlines() if not line.startswith((STARTING, COMPUTING))]
        assert len(lines) == 1
        assert lines[0].startswith("amb-cosim: ")
        assert result.stdout == ""
        assert sorted(path.name for path in tmp_path.iterdir()) == before
        return result.stderr

    return check


@pytest.fixture
def check_picture() -> Callable[[Path], None]:
    """`check_picture(path)`: a picture of 600 pixels or more is there, and something is drawn on it."""

    def check(path: Path) -> None:
        picture = imread(path)[:, :, :3]
        assert min(picture.shape[:2]) > 600
        assert 0.01 < (picture.min(axis=2) < 0.99).mean() < 0.8

    return check
