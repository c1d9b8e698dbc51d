"""How near a comparison came to its limit is read from what pytest says of it."""

from __future__ import annotations

import pytest

from tools.arithmetic.margins import _ratio

SHORTENED = r"b'\x00\...00\x80@\x00' == b'\x00\...00\x80@\x00'"


@pytest.mark.parametrize(
    ("said", "ratio"),
    [
        ("0.5 < (1.0 * 2)", 0.25),
        ("np.float64(3.0) >= 2", 2.0 / 3.0),
        ("-1.0 < 2.0", None),
        ("3 == 3", None),
        ("'a' < 'b'", None),
        (SHORTENED, None),
    ],
)
def test_the_margin_of_a_comparison_is_one_number_over_the_other(said, ratio, recwarn):
    assert _ratio(said) == (ratio if ratio is None else pytest.approx(ratio))
    assert not recwarn.list
