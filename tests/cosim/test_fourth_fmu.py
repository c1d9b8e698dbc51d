"""The example of an FMU from outside: sensors with a lag between rotor and controller."""

import json
import os
import shutil
import tomllib
from pathlib import Path

import numpy as np
import pytest
from command_line import run_command

EXAMPLE = Path(__file__).parents[2] / "examples" / "lag_sensor"
UNTIL = "0.15"


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return an environment in which the example is installed as a separate distribution."""
    site = tmp_path_factory.mktemp("site")
    shutil.copytree(EXAMPLE / "lag_sensor", site / "lag_sensor", ignore=shutil.ignore_patterns("__pycache__"))
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    facts = site / f"lag_sensor-{project['version']}.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    points = [
        f"[{group}]\n" + "".join(f"{name} = {target}\n" for name, target in entries.items())
        for group, entries in project["entry-points"].items()
    ]
    (facts / "entry_points.txt").write_text("\n".join(points))
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(site), os.environ.get("PYTHONPATH", "")])}


def dataset_of(environment: dict[str, str], folder: Path, scenario: str, *options: str) -> dict[str, np.ndarray]:
    import xarray as xr

    values = ("--no-plots", "--until", UNTIL, "-o", folder, *options)
    run_command("run", scenario, *values, cwd=folder.parent, env=environment)
    with xr.open_dataset(folder / "result.nc", engine="h5netcdf") as dataset:
        return {name: variable.values for name, variable in dataset.items()}


@pytest.mark.slow
def test_sensors_without_lag_change_no_bit(installed, tmp_path):
    """With exp(-h/tau) = 0 the sensors pass on their inputs, and Gauss-Seidel order adds no delay."""
    scenario = str(EXAMPLE / "compressor_with_sensors.toml")
    options = ("--set", "sensors.time_constant=1e-9", "--flavour", "python")
    result = dataset_of(installed, tmp_path / "with", scenario, *options)
    base = dataset_of(installed, tmp_path / "without", "compressor_levitated")
    assert np.ptp(base["amb_actuator.mb1.f_x"]) > 1.0
    for name, values in base.items():
        np.testing.assert_array_equal(result[name], values, err_msg=name)


@pytest.mark.slow
def test_lag_of_the_sensors_is_that_of_a_held_input(installed, tmp_path):
    scenario = str(EXAMPLE / "compressor_with_sensors.toml")
    result = dataset_of(installed, tmp_path / "lag", scenario, "--flavour", "python")
    remainder = np.exp(-100e-6 / 50e-6)
    s, m = result["rotor_contact.at_mb2.x"], result["sensors.m3"]
    expected = s[:-1] + (m[:-1] - s[:-1]) * remainder
    np.testing.assert_allclose(m[1:], expected, rtol=0.0, atol=1e-12 * np.max(np.abs(s)))
    assert np.max(np.abs(m[1:] - s[:-1])) > 1e-8, "there is a lag"


def test_a_model_that_is_not_installed_is_refused(tmp_path):
    refused = run_command("run", EXAMPLE / "compressor_with_sensors.toml", cwd=tmp_path, code=2)
    assert json.dumps(refused.stderr).count("no FMU") == 1
