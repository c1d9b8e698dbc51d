"""Units: exponents of the FMI base units, and conversions with pint.

Texts are converted in exact arithmetic and rounded once, so that `50 us`, `0.05 ms` and `5e-5 s` are the same number.

Importing pint and reading its definitions takes 0.8 s, longer than a run or a build. Therefore, the SI units of models
and the most common conversions are listed here, and pint is loaded only for others.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING

from fmi_export.building.number_texts import plain_forms
from fmi_export.building.unit_names import advice, is_ambiguous, lower_case

if TYPE_CHECKING:
    import pint

SI = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_PINT_NAMES = dict(
    zip(("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela", "radian"), SI, strict=True)
)

# Units of SI, as exponents of the base units; products and quotients of them need no pint.
SI_UNITS = {
    **{unit: {unit: 1} for unit in SI},
    "Hz": {"s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "V": {"kg": 1, "m": 2, "s": -3, "A": -1},
    "Ohm": {"kg": 1, "m": 2, "s": -3, "A": -2},
    "H": {"kg": 1, "m": 2, "s": -2, "A": -2},
    "T": {"kg": 1, "s": -2, "A": -1},
}
# Nominal sizes by unit: displacements of a rotor in its clearances, currents, forces. Importers scale tolerances by
# them; the default would be 1, as if a rotor moved by metres.
NOMINAL = {"m": 1e-4, "A": 1.0, "N": 1e3}

FACTOR = re.compile(r"([A-Za-z]+)(-?\d+)?")
# A unit as text without parentheses: names with small exponents. Pint would evaluate any expression.
_NAME = r"(?:1|%|°?[^\W\d]+(?:(?:\*\*|\^)?-?\d{1,2})?)"
UNIT = re.compile(rf"{_NAME}(?:\s*[./*\s]\s*{_NAME})*")
LONGEST_UNIT = 60  # characters
LEAST, MOST = 1e-100, 1e100  # sizes of numbers whose squares and products are still numbers
QUOTIENT = re.compile(r"([^/()]+)(?:/(?:\(([^/()]+)\)|([^/().]+)))?")

PI = Fraction("3.1415926535897932384626433832795028841971693993751")
MILLI, MICRO = Fraction(1, 10**3), Fraction(1, 10**6)

# The first unit in terms of the second.
COMMON = {
    ("mm", "m"): MILLI,
    ("um", "m"): MICRO,
    ("mm/s", "m/s"): MILLI,
    ("ms", "s"): MILLI,
    ("us", "s"): MICRO,
    ("g.m", "kg.m"): MILLI,
    ("g.mm", "kg.m"): MICRO,
    ("kg.mm", "kg.m"): MILLI,
    ("Hz", "rad/s"): 2 * PI,
    ("rpm", "rad/s"): PI / 30,
    ("kHz", "Hz"): Fraction(10**3),
    ("Hz", "1/s"): Fraction(1),
    ("deg", "rad"): PI / 180,
    ("kN", "N"): Fraction(10**3),
    ("kW", "W"): Fraction(10**3),
    ("N/mm", "N/m"): Fraction(10**3),
    ("N/um", "N/m"): Fraction(10**6),
    ("kN/mm", "N/m"): Fraction(10**6),
    ("um/N", "m/N"): MICRO,
    ("mm2", "m2"): MICRO,
    ("cm2", "m2"): Fraction(1, 10**4),
    ("cm^2", "m2"): Fraction(1, 10**4),
    ("m/s^2", "m/s2"): Fraction(1),
    ("mA", "A"): MILLI,
    ("mH", "H"): MILLI,
    ("%", "1"): Fraction(1, 100),
}

# Units of the trade that pint does not know, or takes for others (Nm for the fineness of yarn, mil for an angle, U for
# the activity of an enzyme). An exponent belongs to the last factor of a product: kgm2 is kg m2.
TRADE = {
    "kRPM": "krpm",
    **dict.fromkeys(("U", "Umdr", "r", "rev", "revs", "tr", "giri", "varv", "omw", "ob", "obr"), "turn"),
    "cpm": "(turn/minute)",
    "cps": "(turn/second)",
    "rph": "(turn/hour)",
    "ips": "(inch/second)",
    "kp": "kilogram_force",
    "lbm": "pound",
    "gn": "standard_gravity",
    **dict.fromkeys(("PS", "CV"), "metric_horsepower"),
    **{"gauss": "tenth_of_mT", "kilogauss": "kilotenth_of_mT"},  # that of pint is of the Gaussian system
    "bhp": "hp",
    **dict.fromkeys(("var", "VAr"), "volt_ampere"),
    **dict.fromkeys(("mil", "mils"), "thou"),
    **dict.fromkeys(("amp", "amps"), "ampere"),
}
PRODUCTS = {
    **{f"{prefix}Nm": f"{prefix}N*m" for prefix in ("", "u", "m", "c", "da", "k", "M")},
    **{f"{prefix}Ns": f"{prefix}N*s" for prefix in ("", "m", "k", "M")},
    **{f"{prefix}Pas": f"{prefix}Pa*s" for prefix in ("", "m")},
    **{f"N{length}m": f"N*{length}m" for length in ("m", "c")},
    **{f"g{length}m": f"g*{length}m" for length in ("m", "c")},
    **{f"{weight}{length}m": f"{weight}*{length}m" for weight in ("kg", "kgf") for length in ("", "m", "c")},
    "kpm": "kgf*m",
    "Nms": "N*m*s",
    "Vs": "V*s",
    "As": "A*s",
}
# Masses that the trade writes for their weights, as in a torque of 5 lb-in, where a force is meant.
POUNDS = {
    **dict.fromkeys(("lb", "lbs", "pound", "pounds"), "lbf"),
    **dict.fromkeys(("oz", "ounce", "ounces"), "ozf"),
}
# The acceleration of gravity, which has the symbol of the gram; it is meant where an acceleration is.
GRAVITY = {"g": "standard_gravity"}
# Abbreviations with full stops, such as r.p.m. and in., which are no products.
INITIALS = re.compile(r"\b([rcRC])\.\s?([pP])\.\s?([msMS])\b\.?")
STOP = re.compile(r"(?<=[A-Za-z])\.(?=$|[/)*-]|\s*$)")
# Signs of printed units, as the text has them in FMI notation.
SIGNS = str.maketrans({**dict.fromkeys("·⋅∙•×", "*"), **dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))})

# Display units by unit, unless the variable has its own.
DISPLAYED = {
    "rad/s": "rpm",
    "rad": "deg",
    "m": "mm",
    "m2": "mm2",
    "s": "us",
    "K": "degC",
    "kg.m": "g.mm",
    "N/m": "N/um",
    "m/N": "um/N",
}


def display_unit(unit: str, name: str) -> dict[str, float]:
    """Return the `factor` and, if needed, the `offset` that convert values in `unit` to a display unit.

    Raises
    ------
    ValueError
        If `name` is not a unit of the same dimension as `unit`.
    """
    if (unit, name) == ("K", "degC"):
        return {"factor": 1.0, "offset": -273.15}
    return {"factor": 1.0 / to_unit(f"1 {name}", unit, f"the display unit {name}")}


@cache
def registry(numbers: type = Fraction) -> pint.UnitRegistry:  # type: ignore[type-arg]
    """Return pint's units, with `Ohm`, `Torr` and the SI's gauss added; conversions use numbers of the given type."""
    import pint

    units: pint.UnitRegistry = pint.UnitRegistry(non_int_type=numbers)  # type: ignore[type-arg]
    for definition in ("@alias ohm = Ohm", "@alias torr = Torr", "tenth_of_mT = 1e-4 * tesla"):
        units.define(definition)
    return units


def parse_unit(unit: str, numbers: type = Fraction) -> pint.Unit:
    """Return the unit of `registry(numbers)` for a unit in FMI notation.

    In FMI notation, `.` denotes a product, and a digit after a letter is an exponent.

    Raises
    ------
    ValueError
        If the unit is unknown.
    """
    plain = _plain(unit)
    try:
        text = re.sub(r"([^\W\d]+)((?:\*\*|\^)?-?\d{1,2})?", _spelled, plain.replace(".", "*"))
        text = re.sub(r"(?<=[A-Za-z])(-?\d)", r"**\1", text)
        if len(unit) > LONGEST_UNIT or not UNIT.fullmatch(plain.replace("(", "").replace(")", "")):
            raise ValueError("it is not a product or quotient of units")
        return registry(numbers).Unit("" if text == "1" else text)
    except Exception as error:  # errors of pint, and of the calculator that reads its texts
        name = _shortened(unit)
        raise ValueError(
            f"unknown unit {name!r}{advice(name)}; use SI units such as m, mm, kg.m, N, N.s/m, rad/s, Hz"
        ) from error


def _shortened(text: str) -> str:
    return text if len(text) <= LONGEST_UNIT else f"{text[:LONGEST_UNIT]}..."


def _plain(unit: str) -> str:
    """Return a unit in FMI notation, with typographic signs, hyphens (`oz-in`) and a leading `/` replaced."""
    text = STOP.sub("", INITIALS.sub(lambda match: "".join(match.groups()).lower(), unit.strip()))
    text = re.sub(r"°(?![A-Za-z])", "deg", text.translate(SIGNS)).replace("‰", "permille")
    return re.sub(r"^/", "1/", re.sub(r"(?<=[A-Za-z])-(?=[A-Za-z])", "*", text))


def _spelled(match: re.Match[str]) -> str:
    """Return a unit name with its exponent, as pint spells them."""
    if is_ambiguous(match[1]):
        raise ValueError(f"{match[1]} is the name of several units")
    name, exponent = lower_case(match[1]), match[2] or ""
    product = PRODUCTS.get(name, name if "*" in name else "")
    return f"({product}{exponent})" if product else TRADE.get(name, name) + exponent


def base_unit(unit: str) -> dict[str, float | int]:
    """Return a unit's exponents of the FMI base units (kg, m, s, A, K, mol, cd, rad), and its `factor` if not 1.

    Examples
    --------
    >>> base_unit("N.s/m")
    {'kg': 1, 's': -1}
    """
    si_exponents = _of_si(unit)
    if si_exponents is not None:
        return si_exponents
    parsed = parse_unit(unit)
    quantity = registry().Quantity(Fraction(1), parsed).to_base_units()
    exponents: dict[str, float | int] = {}
    for name, power in quantity.unit_items():
        if name not in _PINT_NAMES:  # a bit or a count, which has no dimension
            continue
        if power != round(float(power)):  # type: ignore[arg-type]
            raise ValueError(f"unit {unit!r} has a fractional exponent, which FMI cannot express")
        exponents[_PINT_NAMES[name]] = round(float(power))  # type: ignore[arg-type]
    if not math.isclose(float(quantity.magnitude), 1.0, rel_tol=1e-12):
        exponents["factor"] = float(quantity.magnitude)
    return {name: exponents[name] for name in (*SI, "factor") if name in exponents}


def _of_si(unit: str) -> dict[str, float | int] | None:
    """Return the exponents of a unit that is a product or quotient of `SI_UNITS` in FMI notation, else None."""
    quotient = QUOTIENT.fullmatch(unit)
    if quotient is None:
        return None
    total = dict.fromkeys(SI, 0)
    for side, sign in ((quotient[1], 1), (quotient[2] or quotient[3], -1)):
        for factor in side.split(".") if side and side != "1" else ():
            power = FACTOR.fullmatch(factor)
            if power is None or power[1] not in SI_UNITS:
                return None
            for base, exponent in SI_UNITS[power[1]].items():
                total[base] += sign * int(power[2] or 1) * exponent
    return {base: exponent for base, exponent in total.items() if exponent}


def to_unit(text: str | float, unit: str, name: str) -> float:
    """Convert `text`, such as `0.75 mm` or `25 g.m`, to a number in `unit`, which is also its default unit.

    Hz and 1/min count revolutions if they are converted to an angular velocity or from it: 3000 1/min are 50 Hz and
    314 rad/s. A reciprocal second is refused there, because it may count radians or revolutions.

    Raises
    ------
    ValueError
        If `text` is not a number, if its unit is unknown or has another dimension, or if the number is too large or too
        small for calculations. Infinities and NaN are returned, so the caller must check for them.

    Examples
    --------
    >>> to_unit("0.75 mm", "m", "clearance")
    0.00075
    >>> to_unit("50 Hz", "rad/s", "speed")
    314.1592653589793
    >>> to_unit("3 kg", "m", "clearance")
    Traceback (most recent call last):
    ValueError: clearance = '3 kg' has unit kg, which cannot be converted to m
    """
    try:
        value = _converted(text, unit, name)
    except OverflowError:
        value = math.inf
    is_infinity = str(text).strip("+- ").startswith("inf")
    if 0.0 < abs(value) < LEAST or (abs(value) > MOST and not is_infinity):
        allowed = f"from {LEAST:g} to {MOST:g}{f' {unit}' if unit != '1' else ''} in magnitude, or 0"
        raise ValueError(f"{name} = {_shortened(str(text))} is not allowed; it must be {allowed}")
    return value


def _converted(text: str | float, unit: str, name: str) -> float:
    if isinstance(text, int | float):
        return float(text)
    text = text.replace("−", "-")
    match = re.fullmatch(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[+-]?inf|nan)\s*(.*?)\s*", text)
    if match is None:
        with_unit = f" or {name}='0.5 {unit}'" if unit != "1" else ""
        raise ValueError(f"{name} = {text!r} is not a number; write for example {name}=0.5{with_unit}")
    number, text_unit = float(match[1]), match[2]
    if not text_unit or text_unit == unit:
        return number
    if forms := plain_forms(text):
        raise ValueError(
            f"{name} = {text[:LONGEST_UNIT]!r} is not allowed: numbers take a decimal point and no other separators; "
            f"write {' or '.join(forms)}"
        )
    exact = Fraction(Decimal(match[1])) if math.isfinite(number) and number else None  # 1e999999999 has too many digits
    if (text_unit, unit) in COMMON:
        return number if exact is None else float(exact * COMMON[text_unit, unit])
    return _by_pint(number, exact, text_unit, unit, f"{name} = {_shortened(text)!r}")


def _as_weights(unit: str, forces: Mapping[str, str]) -> str:
    """Return a unit with its units of mass replaced by others; `forces` maps the former to the latter."""
    names = rf"(?<![^\W\d])({'|'.join(forces)})(?![^\W\d])"
    return re.sub(names, lambda match: forces[match[1].lower()], unit, flags=re.IGNORECASE)


def _by_pint(number: float, exact: Fraction | None, text_unit: str, unit: str, what: str) -> float:
    """Convert `exact` to `unit`; if pint requires a float, as for logarithmic units (dB), convert `number` instead."""
    import pint

    def converted(value: float | Fraction) -> float | Fraction:
        numbers: type = type(value)
        source, target = parse_unit(text_unit, numbers), parse_unit(unit, numbers)
        result: float | Fraction = registry(numbers).Quantity(value, source).to(target).magnitude
        return result

    try:
        if exact is not None:
            with suppress(TypeError):
                if unit == "1" and base_unit(text_unit) == base_unit("turn"):  # a coil of 36 turns has no 226 rad
                    raise ValueError(
                        f"{text_unit} means an angle of 2 pi, not a number; write the number without a unit"
                    )
                value, turns = converted(exact), _revolution(text_unit, unit)
                if turns != 1 and (readings := _readings(value, turns, text_unit, unit)):
                    raise ValueError(readings)
                return float(value * turns)
        return float(converted(number))
    except pint.DimensionalityError as error:
        hint = advice(text_unit)
        for other in (POUNDS, GRAVITY):
            if (weighed := _as_weights(text_unit, other)) != text_unit:
                with suppress(ValueError):
                    return _by_pint(number, exact, weighed, unit, what)
        if (weighed := _as_weights(text_unit, {"kg": "kgf"})) != text_unit:
            with suppress(ValueError):
                _by_pint(number, exact, weighed, unit, what)
                hint = f"; a kilogram-force is kgf, as in {weighed}"
        raise ValueError(f"{what} has unit {text_unit}, which cannot be converted to {unit}{hint}") from error
    except ValueError as error:  # of `parse_unit`
        raise ValueError(f"{what}: {error}") from error


def _readings(value: float | Fraction, turns: Fraction, text_unit: str, unit: str) -> str:
    """Return both readings of a conversion between 1/s and an angular velocity; empty for Hz, 1/min and the like.

    A reciprocal second is the unit of a rate, of revolutions and, because a radian is a number, of an angular velocity.
    A name such as Hz or rev/s means revolutions, and 1/min those of a machine.

    Parameters
    ----------
    value
        The number in `unit` if a radian is a number.
    turns
        Factor for counting revolutions, 2 pi or 1/(2 pi).
    """
    reciprocal = text_unit if turns > 1 else unit
    if any(not str(name).endswith("second") for name in registry().Unit(parse_unit(reciprocal))._units):
        return ""
    revolutions_unit = {"rad/s": "Hz"}.get(unit, unit.replace("rad", "turn")) if turns > 1 else unit
    revolutions = float(value if turns > 1 else value * turns)
    return (
        f"{text_unit} may count radians or revolutions; write '{float(value):.9g} {unit}' or "
        f"'{revolutions:.9g} {revolutions_unit}'"
    )


def _revolution(text_unit: str, unit: str) -> Fraction:
    """Return 2 pi for converting a reciprocal time to an angular velocity, 1/(2 pi) for the reverse, otherwise 1.

    Because pint treats a radian as 1, 16 Hz would otherwise silently become a speed of 16 rad/s.
    """
    first, second = (
        {base: power for base, power in base_unit(text).items() if base != "factor"} for text in (text_unit, unit)
    )
    for factor, (turning, angular) in ((2 * PI, (first, second)), (1 / (2 * PI), (second, first))):
        if set(turning) == {"s"} and turning["s"] < 0 and angular == turning | {"rad": 1}:
            return factor
    return Fraction(1)
