"""What campaigns share: how long they are."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "support"))


@pytest.fixture
def rounds(is_long: bool) -> int:
    return 300 if is_long else 10


@pytest.fixture
def chance(first_seed: int) -> random.Random:
    print(f"seed {first_seed}")
    return random.Random(first_seed)
