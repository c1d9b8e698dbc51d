"""Start values of other tools' states: FMI lets a user set outputs and local variables that are exact or approx."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from fmu_systems import write_system

import amb_cosim
from tests.ssp import gain_archives
from tests.support.c_fmus import OUTPUT, described
from tests.support.messages import raises_naming

BRIEF = '<ssd:DefaultExperiment stopTime="0.01"/>'
SOURCE = Path(__file__).parent / "support" / "falling.c"
VARIABLES = [
    ("h", f'{OUTPUT} initial="exact"', 'Real start="1.0"'),
    ("v", 'causality="local" initial="approx"', 'Real start="0.0"'),
    ("e", OUTPUT, "Real"),
    ("g", 'causality="local" variability="constant" initial="exact"', 'Real start="9.81"'),
]


@pytest.fixture(params=[2, 3])
def fmu(fmu_from_c, request) -> Path:
    return fmu_from_c(SOURCE, described("Falling", VARIABLES, request.param), request.param, "falling")


def run(fmu: Path, folder: Path, event: str = "", more: str = "", **options: object) -> xr.Dataset:
    """Run the mass alone."""
    path = write_system(folder, {"mass": fmu}, event=event, more=more)
    return amb_cosim.simulate(path, isolated=False, **options).dataset


def test_a_state_starts_where_the_user_puts_it(fmu, tmp_path):
    """h = h0 + v0 t - g t^2 / 2 for a local and an output state; both are recorded as the run's start values."""
    data = run(fmu, tmp_path, set={"mass.h": 3.0, "mass.v": "2.0"})
    t = data["time"].values
    np.testing.assert_allclose(data["mass.h"], 3.0 + 2.0 * t - 0.5 * 9.81 * t**2, rtol=1e-12)
    assert data["mass.e"].values == pytest.approx(9.81 * 3.0 + 2.0, rel=1e-12)
    stored = json.loads(data.attrs["parameters"])["mass"]
    assert (stored["h"], stored["v"]) == (3.0, 2.0)


def test_a_parameter_set_of_an_archive_holds_the_start_of_a_state(fmu, tmp_path):
    element = gain_archives.component("mass", "Falling.fmu", "")
    text = gain_archives.structure(
        gain_archives.system("root", "", element, bindings=gain_archives.bind({"mass.h": 7.0})), experiment=BRIEF
    )
    with zipfile.ZipFile(tmp_path / "fall.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", text)
        archive.write(fmu, "Falling.fmu")
    result = amb_cosim.simulate(tmp_path / "fall.ssp", step_size=1e-3, isolated=False).dataset
    assert result["mass.h"].values[0] == 7.0


@pytest.mark.parametrize(("more", "h"), [("", 1.0), ("[parameters.mass]\nh = 5.0\n", 5.0)], ids=["FMU", "system file"])
def test_a_state_starts_as_its_fmu_or_the_system_file_says(fmu, tmp_path, more, h):
    assert run(fmu, tmp_path, more=more)["mass.h"].values[0] == h


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("mass.e", {"set": {"mass.e": 1.0}}),
        ("mass.g", {"set": {"mass.g": 1.0}}),
        ("mass.h", {"event": '"mass.h" = 2.0'}),
    ],
    ids=["calculated", "constant", "during the run"],
)
def test_a_value_that_the_fmu_alone_computes_cannot_be_set(fmu, tmp_path, name, options):
    with raises_naming(ValueError, name, "cannot be set"):
        run(fmu, tmp_path, **options)
