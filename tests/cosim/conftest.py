"""FMUs that are not this project's, built once by PythonFMU."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parent / "support"


@pytest.fixture(scope="session")
def foreign_fmus(create_once: Callable[..., Path]) -> Path:
    """Folder with `Mass.fmu`, `Spring.fmu` and `Unruly.fmu`."""
    from pythonfmu.builder import FmuBuilder

    def fill(folder: Path) -> None:
        for script in SUPPORT.glob("*.py"):
            FmuBuilder.build_FMU(script, dest=folder)

    return create_once("foreign-fmus", fill)
