"""The small model that the tests of the export are run on."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def fmu(build_fmu, unpack, lag) -> Path:
    """Folder of the extracted FMU of the lag, where its kernels are compiled once."""
    return unpack(build_fmu(lag))
