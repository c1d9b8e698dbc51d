"""The small model that the tests of the export are run on."""

import zipfile
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def fmu(build_fmu, lag, tmp_path_factory) -> Path:
    """Folder of the extracted FMU of the lag, where its kernels are compiled once."""
    folder = tmp_path_factory.mktemp("fmu")
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        archive.extractall(folder)
    return folder
