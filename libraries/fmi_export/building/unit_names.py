"""Written-out names of units in any case, and unit symbols that are ambiguous or in the wrong case."""

from __future__ import annotations

import re
from collections.abc import Iterable

# Words of SI, which also form products, as Newtonmeter.
OF_SI = (
    *("meter", "metre", "second", "minute", "hour", "gram", "liter", "litre", "mole", "kelvin", "celsius", "radian"),
    *("newton", "pascal", "joule", "watt", "volt", "ampere", "ohm", "henry", "tesla", "weber", "siemens", "coulomb"),
    *("farad", "hertz", "gramme", "henrie", "sekunde", "sekunden", "minuten", "stunde", "stunden", "gramm"),
)
# Words and abbreviations that mean the same in any case, unlike symbols: mN is no MN.
WORDS = (
    *OF_SI,
    *("micron", "inch", "inches", "foot", "feet", "mil", "thou", "zoll", "pound", "ounce", "tonne", "tonnen"),
    *("lb", "lbf", "kgf", "pond", "dyne", "bar", "torr", "psi", "ksi", "hp", "horsepower", "poise", "stokes"),
    *("sec", "min", "hr", "day", "gauss", "erg", "calorie", "amp", "fahrenheit", "percent", "prozent"),
    *("rad", "degree", "deg", "turn", "rev", "revolution", "cycle", "rpm", "upm", "rps", "cpm", "cps"),
    *("umdrehung", "umdrehungen"),
)
PREFIXES = (
    *("pico", "nano", "micro", "mikro", "milli", "centi", "zenti", "deci", "dezi", "deca", "deka", "hecto", "hekto"),
    *("kilo", "mega", "giga", "tera"),
)
TRANSLATED = {
    **{"mikro": "micro", "zenti": "centi", "dezi": "deci", "deka": "deca", "hekto": "hecto"},
    **{"gramme": "gram", "gramm": "gram", "henrie": "henry", "tonnen": "tonne", "zoll": "inch", "prozent": "percent"},
    **{"sekunde": "second", "sekunden": "second", "minuten": "minute", "stunde": "hour", "stunden": "hour"},
    **{"umdrehung": "turn", "umdrehungen": "turn", "upm": "rpm"},
}
SYMBOLS = (
    *("m", "mm", "um", "nm", "km", "cm", "s", "ms", "us", "ns", "h", "Hz", "kHz", "MHz", "GHz"),
    *("kg", "g", "mg", "N", "kN", "MN", "mN", "Nm", "kNm", "Pa", "kPa", "MPa", "GPa", "mbar", "J", "kJ", "MJ"),
    *("W", "kW", "MW", "mW", "V", "kV", "mV", "A", "kA", "mA", "uA", "Ohm", "kOhm", "mOhm", "H", "mH", "uH", "T"),
    *("mT", "K", "degC", "degF", "in", "ft", "yd", "oz", "ozf", "rad", "mrad", "krpm"),
)
# Names of several units: pint takes Grad for 1e9 rad, grad for a gon, gr for a grain and a ton for that of the USA.
AMBIGUOUS = {"grad": "deg or gon", "gr": "g or grain", "ton": "t, short_ton or long_ton"}


def _any_of(names: Iterable[str]) -> str:
    return "|".join(sorted(names, key=len, reverse=True))


_OF_SI = rf"(?:{_any_of(PREFIXES)})?(?:{_any_of(OF_SI)})"
_WORD = re.compile(rf"({_any_of(PREFIXES)})?({_any_of(WORDS)})s?", re.IGNORECASE)
_PRODUCT = re.compile(rf"({_OF_SI})((?:{_OF_SI})+)s?", re.IGNORECASE)


def lower_case(name: str) -> str:
    """Return a written-out name in its usual spelling, and a product as its factors; other names are unchanged.

    Examples
    --------
    >>> lower_case("Newton"), lower_case("MILLIMETRES"), lower_case("Newtonmeter"), lower_case("kN")
    ('newton', 'millimetre', 'newton*meter', 'kN')
    """
    if word := _WORD.fullmatch(name):
        return "".join(TRANSLATED.get(part.lower(), part.lower()) for part in word.groups(""))
    product = _PRODUCT.fullmatch(name)
    return name if product is None else f"{lower_case(product[1])}*{lower_case(product[2])}"


def is_ambiguous(name: str) -> bool:
    """Return whether several units have this name."""
    return re.sub("s$", "", name.lower()) in AMBIGUOUS


def advice(unit: str) -> str:
    """Return advice on ambiguous names and on symbols in the wrong case, such as `KN`; empty if none is needed."""
    names = re.findall(r"[^\W\d_]+", unit)
    ambiguous = [f"{name} may be {AMBIGUOUS[re.sub('s$', '', name.lower())]}" for name in names if is_ambiguous(name)]
    mistaken = []
    for name in names:
        alike = [symbol for symbol in SYMBOLS if symbol.lower() == name.lower()]
        if alike and name not in alike and not _WORD.fullmatch(name):
            mistaken.append(f"{name} may be {' or '.join(alike)}")
    return "".join(
        [
            f"; {', '.join(ambiguous)}" if ambiguous else "",
            f"; the case of letters matters: {', '.join(mistaken)}" if mistaken else "",
        ]
    )
