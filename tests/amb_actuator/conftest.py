"""The fixture `bearing`: a running actuator."""

from collections.abc import Callable

import pytest
from running_actuator import running_actuator

from fmi_export.model import Instance


@pytest.fixture(scope="session")
def bearing() -> Callable[..., Instance]:
    """`bearing(values={}, **values)`: an initialised actuator."""
    return running_actuator
