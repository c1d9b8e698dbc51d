"""The small model that the tests of the export are run on."""

from __future__ import annotations

import importlib

import pytest

from fmi_export.model import Model


@pytest.fixture(scope="session")
def lag() -> Model:
    """A first-order lag with state, all variable types, ranges and faults (`support/probe_lag`)."""
    return importlib.import_module("probe_lag.lag").MODEL
