"""Archives written once, and the tools beside the tests of this folder for them to import."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

import tools


@pytest.fixture(scope="session")
def archive(run_python, create_once):
    """`archive(name, scenario, ..)`: path of the archive of a scenario, written once."""

    def write(name, scenario, **options):
        def fill(folder):
            run_python(tools.exported, scenario=scenario, archive=str(folder / "rig.ssp"), **options, timeout=900)

        return create_once(f"archive-{name}", fill) / "rig.ssp"

    return write
