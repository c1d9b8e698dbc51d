"""Archives written once, and the runs of archives in other tools, for the tests of this folder to import."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import archive_runs


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
