"""Parameters of a test of which the first is run always and the others are marked slow."""

from collections.abc import Iterable
from typing import Any

import pytest


def slow_but_first(values: Iterable[Any]) -> list[Any]:
    """Return the values for `pytest.mark.parametrize`, all but the first marked slow."""
    first, *others = values
    return [first, *(pytest.param(value, marks=pytest.mark.slow) for value in others)]
