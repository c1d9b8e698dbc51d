"""Runs of the expander that tests share."""

import pytest
from strange_machine import LEVITATION, RUB, TOUCHDOWN

import amb_cosim


@pytest.fixture(scope="session")
def levitation() -> amb_cosim.Result:
    """A step of unbalance that the expander holds without contact."""
    return amb_cosim.run(LEVITATION)


@pytest.fixture(scope="session")
def touchdown() -> amb_cosim.Result:
    """A fall onto the retainers."""
    return amb_cosim.run(TOUCHDOWN)


@pytest.fixture(scope="session")
def rub() -> amb_cosim.Result:
    """A rub at seal and turbine, and at a retainer."""
    return amb_cosim.run(RUB)
