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


def in_host(tool: str, fmus: str, what: str = "this master's run, to the last bit") -> Callable[[Any], Any]:
    """Mark a test that runs FMUs in a tool, which is skipped where the tool is not installed."""
    name = DISTRIBUTIONS[tool]
    package = name.replace("-", "_")
    is_missing = find_spec(package) is None

    def mark(test: Any) -> Any:
        skipped = pytest.mark.skipif(is_missing, reason=f"{package} is not installed (extra: peers)")(test)
        return pytest.mark.host(tool, name, fmus=fmus, what=what)(skipped)

    return mark
