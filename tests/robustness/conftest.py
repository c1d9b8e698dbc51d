"""What campaigns share: how long they are, and FMUs to call."""

from __future__ import annotations

import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent / "support"))


@pytest.fixture(scope="session")
def fmu_folder() -> Callable[[str, Any], Path]:
    """`fmu_folder(model, flavour)`: where the FMU is extracted."""
    from amb_cosim.cosim.fmu.fmus import ensure_built

    return lambda model, flavour: ensure_built(model, flavour).folder


@pytest.fixture
def rounds(is_long: bool) -> int:
    return 300 if is_long else 10


@pytest.fixture
def chance(first_seed: int) -> random.Random:
    print(f"seed {first_seed}")
    return random.Random(first_seed)
