"""Times as users spell them fall on the point of exact arithmetic, for any step."""

from decimal import Decimal
from fractions import Fraction

import pytest

from amb_cosim.cosim.grid.time_grid import TimeGrid, in_steps, whole_steps
from amb_cosim.cosim.system.values import quantity

UNITS = {"s": 0, "ms": -3, "us": -6, "ns": -9}
STEPS = ("50 us", "0.05 ms", "5e-5", "7 us", "0.125 ms", "33.3 us", "2.5E-4 s")


def spellings(time: Fraction) -> list[str]:
    """Return a time (s) that has finitely many digits in all units, with a fixed point and with an exponent."""
    seconds = Decimal(time.numerator) / Decimal(time.denominator)
    numbers = {unit: seconds.scaleb(-power) for unit, power in UNITS.items()}
    return [format(number, form) + f" {unit}" for unit, number in numbers.items() for form in "fE"]


@pytest.mark.parametrize("step", STEPS)
def test_every_spelling_of_a_time_gives_the_same_grid_point(step):
    h = quantity(step, "s", "step")
    exact = Fraction(str(h))
    for steps in (1, 3, 60, 999, 12_345, 720_000, 10_000_001):
        for part in (Fraction(0), Fraction(1, 2), Fraction(-1, 10), Fraction(49, 100)):
            time = (steps + part) * exact
            for text in spellings(time):
                seconds = quantity(text, "s", "time")
                assert TimeGrid(h).nearest("time", seconds) == round(time / exact), (step, text)
                if part == 0:
                    assert whole_steps("time", seconds, h) == steps, (step, text)


@pytest.mark.parametrize("start", [0.0, 0.1, 1.7e9, 1.7e9 + 0.1, 1.7e9 + 0.3, -1.7e9 + 0.7])
@pytest.mark.parametrize("h", [0.1, 1e-3, 1e-4])
def test_whole_steps_from_any_start_time_are_whole(start, h):
    """Seconds since 1970 are rounded to 2.4e-7 s, which made a last step of 2e-8 s."""
    for n in (1, 6, 9, 1000):
        assert in_steps(start + n * h, h, start) == n
        assert TimeGrid(h, start).nearest("stop", start + n * h) == n
        assert TimeGrid(h, start).is_at(n, round(start + n * h, 7))
    assert in_steps(start + 6.4 * h, h, start) == pytest.approx(6.4, abs=0.01)
