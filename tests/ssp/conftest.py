"""Archives written once, and the runs of archives in other tools, for the tests of this folder to import."""

import sys
import zipfile
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import archive_runs
import gain_archives

from tests.cosim.conftest import foreign_fmus
from tests.orchestrator.conftest import refuses, runner

__all__ = ["foreign_fmus", "refuses", "runner"]


@pytest.fixture(scope="session")
def archive(run_python, create_once):
    """`archive(name, scenario, ..)`: path of the archive of a scenario, written once."""

    def write(name, scenario, **options):
        def fill(folder):
            run_python(
                archive_runs.exported, scenario=scenario, archive=str(folder / "rig.ssp"), **options, timeout=900
            )

        return create_once(f"archive-{name}", fill) / "rig.ssp"

    return write


UNITS = {"Plain": None, "Metres": "m", "Millimetres": "mm", "Celsius": "degC", "Fahrenheit": "degF", "Newtons": "N",
         "CelsiusRises": "degC rise", "FahrenheitRises": "degF rise", "Furlongs": "furlong",
         "Counts": "count"}  # fmt: skip


@pytest.fixture(scope="module")
def gains(fmu_from_c, tmp_path_factory):
    """Gains y = k u of several units, each an FMU file."""
    compiled, folder = fmu_from_c(gain_archives.SOURCE, gain_archives.description()), tmp_path_factory.mktemp("gains")
    return {name: gain_archives.write_fmu(folder / f"{name}.fmu", compiled, unit) for name, unit in UNITS.items()}


@pytest.fixture
def gain_archive(gains, tmp_path):
    """`gain_archive(root, units=(), files={})`: an archive with that system and more files."""

    def write(root, units=(), files=None, name="gains.ssp"):
        with zipfile.ZipFile(tmp_path / name, "w") as content:
            content.writestr("SystemStructure.ssd", gain_archives.structure(root, units))
            for fmu, path in gains.items():
                if f"{fmu}.fmu" in root or files:
                    content.write(path, f"resources/{fmu}.fmu")
            for file, text in (files or {}).items():
                content.writestr(file, text)
        return tmp_path / name

    return write


@pytest.fixture
def last(gain_archive):
    """`last(root, **more)`: the last value of every variable."""

    def run(root, set=None, **more):
        import amb_cosim

        dataset = amb_cosim.simulate(gain_archive(root, **more), set=set, isolated=False).dataset
        return {name: dataset[name].values[-1] for name in dataset}

    return run
