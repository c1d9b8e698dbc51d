"""Marks of tests that run FMUs in the programs of other projects: rows of the compatibility page."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest

# Program, and the distribution of Python that brings it
DISTRIBUTIONS = {
    "FMPy": "fmpy",
    "ecos": "ecospy",
    "fmucontainer": "fmu-manipulation-toolbox",
    "fmutool": "fmu-manipulation-toolbox",
    "libcosim": "libcosimpy",
}


def host_marks(tool: str, fmus: str, what: str = "this master's run, to the last bit") -> list[pytest.MarkDecorator]:
    """Return the marks of a case that runs FMUs in a tool, which is skipped where the tool is not installed."""
    name = DISTRIBUTIONS[tool]
    package = name.replace("-", "_")
    skipped = pytest.mark.skipif(find_spec(package) is None, reason=f"{package} is not installed (extra: peers)")
    return [skipped, pytest.mark.host(tool, name, fmus=fmus, what=what)]


def in_host(*arguments: str) -> Callable[[Any], Any]:
    """Return a decorator with the marks of `host_marks` for a test."""
    skipped, host = host_marks(*arguments)
    return lambda test: host(skipped(test))
