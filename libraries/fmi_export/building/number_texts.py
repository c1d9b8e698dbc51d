"""Numbers with separators in texts, such as `12,000`, which in some countries is twelve thousand, in others twelve."""

from __future__ import annotations

import re

# Up to the next character that is not part of the number: groups of three digits, a decimal comma, a power of ten.
GROUPED = re.compile(
    r"[+-]?([1-9]\d{0,2}(?:,\d{3})+|[1-9]\d{0,2}(?:[ '’_\u202f\u00a0]\d{3})+)(\.\d+)?(?![\d,'’_]|\.\d)"
)
COMMA = re.compile(r"[+-]?(\d+|[1-9]\d{0,2}(?:[. '’_\u202f\u00a0]\d{3})+),(\d+)(?![\d,'’_]|\.\d)")
POWER = re.compile(r"([+-]?\d+\.?\d*)\s*[x×·*]\s*10(?:(?:\^|\*\*)([+-]?\d+)|([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+))")
RAISED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def plain_forms(text: str) -> list[str]:
    """Return the plain forms that the number at the beginning of a text may have; none if it has no separators.

    Examples
    --------
    >>> plain_forms("12,000 rpm")
    ['12000', '12.000']
    >>> plain_forms("1.234,5 mm")
    ['1234.5']
    >>> plain_forms("3x10^4 N/m")
    ['3e4']
    """
    text = text.strip()
    sign, result = re.match("[+-]?", text)[0], []  # type: ignore[index]
    if grouped := GROUPED.match(text):
        result.append(f"{sign}{_digits(grouped[1])}{grouped[2] or ''}")
    if comma := COMMA.match(text):
        result.append(f"{sign}{_digits(comma[1])}.{comma[2]}")
    if power := POWER.match(text):
        result.append(f"{power[1]}e{(power[2] or power[3]).translate(RAISED)}")
    return result


def _digits(text: str) -> str:
    return re.sub(r"\D", "", text)
