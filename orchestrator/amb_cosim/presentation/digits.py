"""Numbers as text, with significant digits."""

from __future__ import annotations


def significant(value: float, digits: int = 4) -> str:
    """Return a number with significant digits, whatever its size, and as 15000, not 1.5e+04.

    Examples
    --------
    >>> significant(4.3214e-5), significant(12345.6), significant(-0.0)
    ('4.321e-05', '12346', '0')
    """
    return f"{value:.0f}" if 10.0**digits <= abs(value) < 1e7 else f"{value:z.{digits}g}"
