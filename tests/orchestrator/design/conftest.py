"""A running actuator and a random receptance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from running_actuator import running_actuator

from fmi_export.model import Instance


@pytest.fixture(scope="session")
def bearing() -> Callable[..., Instance]:
    """`bearing(values={}, **values)`: an initialised actuator."""
    return running_actuator


@pytest.fixture
def receptance() -> NDArray[np.complex128]:
    """A random, well-conditioned 8 x 4 receptance of the size of the rig's (m/N)."""
    rng = np.random.default_rng(7)
    return 1e-6 * (rng.normal(size=(8, 4)) + 1j * rng.normal(size=(8, 4)))
