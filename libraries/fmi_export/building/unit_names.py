"""Written-out names of units in upper and lower case, and symbols whose case was mistaken."""

from __future__ import annotations

import re

PREFIXES = "nano|micro|milli|centi|kilo|mega|giga"
# Words and abbreviations that mean the same in any case, unlike symbols: mN is no MN.
WORDS = (
    *("meter", "metre", "micron", "inch", "inches", "foot", "feet", "mil", "thou"),
    *("second", "sec", "minute", "min", "hour", "hr", "day", "hertz"),
    *("gram", "pound", "lb", "ounce", "tonne"),
    *("newton", "lbf", "kgf", "pascal", "bar", "psi", "ksi", "joule", "watt", "horsepower"),
    *("volt", "ampere", "amp", "ohm", "henry", "tesla", "coulomb", "farad"),
    *("radian", "rad", "degree", "deg", "turn", "rev", "revolution", "cycle", "rpm", "rps", "cpm", "cps"),
    *("kelvin", "celsius", "fahrenheit", "percent"),
)
WORD = re.compile(rf"(?:{PREFIXES})?(?:{'|'.join(WORDS)})s?", re.IGNORECASE)
VARIANTS = {"gramme": "gram", "henries": "henry"}
SYMBOLS = (
    *("m", "mm", "um", "nm", "km", "cm", "s", "ms", "us", "ns", "h", "Hz", "kHz", "MHz", "GHz"),
    *("kg", "g", "mg", "N", "kN", "MN", "mN", "Nm", "kNm", "Pa", "kPa", "MPa", "GPa", "mbar", "J", "kJ", "MJ"),
    *("W", "kW", "MW", "mW", "hp", "V", "kV", "mV", "A", "kA", "mA", "uA", "Ohm", "kOhm", "mOhm", "H", "mH", "uH", "T"),
    *("mT", "K", "degC", "degF", "in", "ft", "yd", "oz", "ozf", "rad", "mrad", "krpm"),
)


def lower_case(name: str) -> str:
    """Return a written-out name, such as `Newton` or `MILLIMETRES`, as it is usually written; others unchanged."""
    for variant, usual in VARIANTS.items():
        name = re.sub(rf"{variant}(s?)$", rf"{usual}\1", name, flags=re.IGNORECASE)
    return name.lower() if WORD.fullmatch(name) else name


def case_advice(unit: str) -> str:
    """Return the advice for symbols in another case than those of units, as `KN`; empty if there are none."""
    mistaken = []
    for name in re.findall(r"[^\W\d_]+", unit):
        meant = [symbol for symbol in SYMBOLS if symbol.lower() == name.lower()]
        if meant and name not in meant and not WORD.fullmatch(name):
            mistaken.append(f"{name} may be {' or '.join(meant)}")
    return f"; the case of letters matters: {', '.join(mistaken)}" if mistaken else ""
