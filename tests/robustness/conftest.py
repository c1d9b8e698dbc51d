"""What campaigns share: how long they are, and FMUs to call."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def is_long(request: pytest.FixtureRequest) -> bool:
    """Whether campaigns are as long as they get: the option `--long`."""
    return bool(request.config.getoption("--long"))


@pytest.fixture
def first_seed(is_long: bool) -> int:
    """The same seed in every short campaign, another in each long one; messages name it."""
    return random.SystemRandom().randrange(10**6) if is_long else 2006


@pytest.fixture(scope="session")
def fmu_folder() -> Callable[[str, Any], Path]:
    """`fmu_folder(model, flavour)`: where the FMU is extracted."""
    from amb_cosim.cosim.fmus import ensure_built

    return lambda model, flavour: ensure_built(model, flavour).folder
