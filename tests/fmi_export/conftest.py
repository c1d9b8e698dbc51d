"""The small model that the tests of the export are run on."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fmi_export.model import Model


@pytest.fixture(scope="session")
def lag() -> Iterator[Model]:
    """A first-order lag with state, all variable types, ranges and faults (`support/probe_lag`)."""
    sys.path.insert(0, str(Path(__file__).parent / "support"))
    yield importlib.import_module("probe_lag.lag").MODEL
    sys.path.remove(str(Path(__file__).parent / "support"))
