"""Numbers as text, with significant digits."""

from __future__ import annotations

import re


def significant(value: float, digits: int = 4) -> str:
    """Return a number of any size as text with significant digits, for example 15000 rather than 1.5e+04.

    Examples
    --------
    >>> significant(4.3214e-5), significant(12345.6), significant(-0.0)
    ('4.321e-05', '12346', '0')
    """
    return f"{value:.0f}" if 10.0**digits <= abs(value) < 1e7 else f"{value:z.{digits}g}"


def with_micro_signs(text: str) -> str:
    """Return a text in which the prefix u of units is replaced by a micro sign.

    Examples
    --------
    >>> with_micro_signs("step (us), norm of H (N/um)")
    'step (µs), norm of H (N/µm)'
    """
    return re.sub(r"\bu([ms])\b", "\N{MICRO SIGN}\\1", text)
