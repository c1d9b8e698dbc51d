"""What campaigns share: how long they are, and FMUs to call."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(scope="session")
def fmu_folder() -> Callable[[str, Any], Path]:
    """`fmu_folder(model, flavour)`: where the FMU is extracted."""
    from amb_cosim.cosim.fmus import ensure_built

    return lambda model, flavour: ensure_built(model, flavour).folder
