"""The small model that the tests of the export are run on."""

from __future__ import annotations

import importlib
import zipfile
from pathlib import Path

import pytest

from fmi_export.model import Model


@pytest.fixture(scope="session")
def lag() -> Model:
    """A first-order lag with state, all variable types, ranges and faults (`support/probe_lag`)."""
    return importlib.import_module("probe_lag.lag").MODEL


@pytest.fixture(scope="module")
def fmu(build_fmu, lag, tmp_path_factory) -> Path:
    """Folder of the extracted FMU of the lag, where its kernels are compiled once."""
    folder = tmp_path_factory.mktemp("fmu")
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        archive.extractall(folder)
    return folder
