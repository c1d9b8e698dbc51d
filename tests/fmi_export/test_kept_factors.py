"""Conversions that pint was asked for once need no pint at the next start."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

CONVERT = """
import sys
from fmi_export.building.units import to_unit
print(to_unit(sys.argv[1], sys.argv[2], "value").hex(), "pint" in sys.modules)
"""


@pytest.fixture
def convert(tmp_path):
    """`convert(text, unit)`: the number, and whether pint was loaded, in a process with a cache of its own."""

    def call(text, unit):
        command, variables = [sys.executable, "-c", CONVERT, text, unit], {"XDG_CACHE_HOME": str(tmp_path)}
        ended = subprocess.run(command, capture_output=True, text=True, env=os.environ | variables, check=True)
        number, loaded = ended.stdout.split()
        return float.fromhex(number), loaded == "True"

    return call


def test_a_second_start_converts_without_pint_to_the_same_bits(convert):
    first, asked = convert("3.7 lbf", "N")
    again, asked_again = convert("3.7 lbf", "N")
    assert (asked, asked_again) == (True, False)
    assert again == first == pytest.approx(3.7 * 4.4482216152605)
    other, asked_other = convert("0.3 lbf", "N")
    assert not asked_other
    assert other == pytest.approx(0.3 * 4.4482216152605, rel=1e-15)


@pytest.mark.slow
def test_a_scale_with_an_offset_is_no_factor(convert):
    for _ in range(2):
        assert convert("20 degC", "K") == (pytest.approx(293.15), True)


@pytest.mark.slow
@pytest.mark.parametrize("content", ["{", '{"pint": "0.0", "factors": {"lbf N": "0x1p+9"}}', '{"factors": 3}'])
def test_a_cache_that_is_damaged_or_of_another_pint_is_not_used(convert, tmp_path, content):
    (tmp_path / "amb-cosim").mkdir()
    (tmp_path / "amb-cosim" / "unit_factors.json").write_text(content, encoding="utf-8")
    assert convert("1 lbf", "N") == (pytest.approx(4.4482216152605), True)
    assert json.loads((tmp_path / "amb-cosim" / "unit_factors.json").read_text(encoding="utf-8"))["pint"] != "0.0"
    assert not convert("1 lbf", "N")[1]
