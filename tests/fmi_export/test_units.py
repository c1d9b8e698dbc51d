"""Units against the SI definitions."""

import math
import re
import time
from contextlib import suppress
from fractions import Fraction

import pytest

from fmi_export.building.units import (
    COMMON,
    DISPLAYED,
    PI,
    SI_UNITS,
    base_unit,
    display_unit,
    parse_unit,
    registry,
    to_unit,
)
from tests.support.messages import assert_names, raises_naming


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("N/m", {"kg": 1, "s": -2}),
        ("N.s/m", {"kg": 1, "s": -1}),
        ("kg.m", {"kg": 1, "m": 1}),
        ("rad/s", {"rad": 1, "s": -1}),
        ("m2", {"m": 2}),
        ("m-2", {"m": -2}),
        ("A", {"A": 1}),
        ("N/A", {"kg": 1, "m": 1, "s": -2, "A": -1}),
        ("T", {"kg": 1, "s": -2, "A": -1}),
        ("Ohm", {"kg": 1, "m": 2, "s": -3, "A": -2}),
        ("1", {}),
        ("Hz", {"s": -1}),
        ("mm", {"m": 1, "factor": 1e-3}),
        ("rpm", {"rad": 1, "s": -1, "factor": 2 * math.pi / 60}),
        ("deg", {"rad": 1, "factor": math.pi / 180}),
    ],
)
def test_base_unit_exponents_match_si(unit, expected):
    assert base_unit(unit) == pytest.approx(expected)


@pytest.mark.parametrize(
    "unit", [*SI_UNITS, "N/(m.s)", "kg.m2/s2", "1/(N.m)", "1/s", "m-2/V", "A2.Ohm", "s.m/rad", "m/N"]
)
def test_si_units_agree_with_pint(unit, monkeypatch):
    found = base_unit(unit)
    monkeypatch.setattr("fmi_export.building.units._of_si", lambda _: None)
    assert list(found.items()) == list(base_unit(unit).items())


POUND, OUNCE, INCH = 0.45359237 * 9.80665, 0.028349523125 * 9.80665, 0.0254
PER_MINUTE = (
    *("1/min", "/min", "min-1", "min^-1", "min⁻¹", "r/min", "rev/min", "revs/min", "U/min", "tr/min", "1/minute"),
    *("RPM", "Rpm", "rpm", "cpm", "CPM"),
)
PER_SECOND = ("Hz", "cps", "rev/s")
RECIPROCAL = ("1/s", "s-1", "s^-1", "/s", "1/second")  # of revolutions or of radians
VALUES = [
    ("0.75 mm", "m", 0.75e-3),
    ("25 g.m", "kg.m", 25e-3),
    ("-1.5e3 N/mm", "N/m", -1.5e6),
    ("90deg", "rad", math.pi / 2),
    ("1 kN", "N", 1e3),
    ("3", "A", 3.0),
    (3, "A", 3.0),
    ("50 %", "1", 0.5),
    ("250 us", "s", 250e-6),
    ("16 Hz", "Hz", 16.0),
    ("20 dB", "1", 100.0),  # without exact arithmetic
    ("3 mN", "N", 3e-3),  # the case of a prefix is that of the symbol
    ("3 MN", "N", 3e6),
    # revolutions are counted by a reciprocal time alone
    *((f"1000 {spelled}", "rad/s", 104.719755119660) for spelled in PER_MINUTE),
    *((f"1000 {spelled}", "Hz", 1000.0 / 60.0) for spelled in PER_MINUTE),
    *((f"60 {spelled}", "rad/s", 376.991118430775) for spelled in PER_SECOND),
    *((f"1000 {spelled}", "Hz", 1000.0) for spelled in RECIPROCAL),
    *((f"7 {spelled}", "1/s", 7.0) for spelled in ("1/s", "s-1", "Hz")),
    ("376.991118430775 rad/s", "Hz", 60.0),
    ("3 1/min/s", "rad/s2", 3 * 2 * math.pi / 60),
    ("5 N.m", "N.m/rad", 5.0),
    ("2 rad", "1", 2.0),
    *((f"3 {spelled}", unit, 3.0) for spelled in ("count", "counts", "bit") for unit in (spelled, "1")),
    # meanings that are suggested for an ambiguous name
    ("90 deg", "rad", math.pi / 2.0),
    ("100 gon", "rad", math.pi / 2.0),
    ("25 g.mm", "kg.m", 25e-6),
    ("1 grain", "kg", 64.79891e-6),
    ("1 t", "kg", 1000.0),
    ("1 short_ton", "kg", 2000.0 * 0.45359237),
    ("1 long_ton", "kg", 2240.0 * 0.45359237),
    # customary units
    *((text, "N.m", 12.0) for text in ("12 Nm", "0.012 kNm", "12000 mNm", "1200 Ncm", "12000 Nmm")),
    ("2 mil", "m", 50.8e-6),
    ("2 mils", "um", 50.8),
    # a pound is a force where a mass has no meaning
    *((f"5 {spelled}", "N.m", 5 * POUND * INCH) for spelled in ("lb-in", "lb.in", "in-lb", "lbf.in", "lbf-in")),
    ("5 ft-lb", "N.m", 5 * POUND * 12 * INCH),
    ("5 oz-in", "N.m", 5 * OUNCE * INCH),
    *((f"5 {spelled}", "N.m", 5 * POUND * 12 * INCH) for spelled in ("foot-pounds", "Pound-Feet", "foot pounds")),
    *((f"5 {spelled}", "N.m", 5 * POUND * INCH) for spelled in ("inch pounds", "Inch-Pounds")),
    ("5 ounce-inches", "N.m", 5 * OUNCE * INCH),
    ("5 lb/in", "N/m", 5 * POUND / INCH),
    ("5 lb.s/in", "N.s/m", 5 * POUND / INCH),
    ("5 lb", "N", 5 * POUND),
    ("5 lb", "kg", 5 * 0.45359237),
    ("5 lb-in", "kg.m", 5 * 0.45359237 * INCH),
    ("5 lb-in2", "kg.m2", 5 * 0.45359237 * INCH**2),
    ("5 lb-in-s2", "kg.m2", 5 * POUND * INCH),
    # the notation of data sheets
    *((f"2 {spelled}", "N.m", 2.0) for spelled in ("N·m", "N⋅m", "N×m", "N-m", "N m", "N*m")),
    *((f"3 {spelled}", "kg.m", 3e-6) for spelled in ("g·mm", "g-mm", "gmm", "g mm", "g.mm")),
    ("3 oz-in", "kg.m", 3 * 0.028349523125 * 0.0254),
    *((f"4 {spelled}", "kg.m2", 4.0) for spelled in ("kg·m²", "kg-m2", "kgm2", "kgm²", "kg m^2")),
    *((f"5 {spelled}", "N.s/m", 5.0) for spelled in ("Ns/m", "N·s/m", "N/(m/s)", "N-s/m")),
    ("5 kNs/m", "N.s/m", 5e3),
    ("6 Nm²", "N.m2", 6.0),
    ("7 1/Nm", "1/(N.m)", 7.0),
    ("8 Nm/rad", "N.m/rad", 8.0),
    ("9 Nms/rad", "N.m.s/rad", 9.0),
    ("2 mPas", "Pa.s", 2e-3),
    ("3 Vs/A", "H", 3.0),
    ("180 °", "rad", math.pi),
    ("180 °/s", "rad/s", math.pi),
    ("20 °C", "K", 293.15),
    ("5 ‰", "1", 5e-3),
    ("1 ips", "m/s", 0.0254),
    ("2 kp", "N", 2 * 9.80665),
    ("2 lbm", "kg", 2 * 0.45359237),
    ("3 gn", "m/s2", 3 * 9.80665),
    *(("1 PS", "W", 735.49875), ("1 CV", "W", 735.49875), ("1 bhp", "W", 745.69987158227022)),
    *(("2 VAr", "W", 2.0), ("5 daNm", "N.m", 50.0), ("5 cNm", "N.m", 0.05), ("2 mTorr", "N/m2", 0.202650 / 0.76)),
    *(("3 kgfm", "N.m", 3 * 9.80665), ("3 kgfcm", "N.m", 0.03 * 9.80665), ("3 kpm", "N.m", 3 * 9.80665)),
    *((f"30 {spelled}/min", "rad/s", math.pi) for spelled in ("giri", "varv", "omw", "ob", "obr", "Umdr")),
    *((f"30 {spelled}", "rad/s", math.pi) for spelled in ("r.p.m.", "r.p.m", "R.P.M.", "c.p.m.", "rev./min")),
    ("1 r.p.s.", "Hz", 1.0),
    ("3 in.", "m", 3 * 0.0254),
    ("3 oz.in.", "kg.m", 3 * 0.028349523125 * 0.0254),
    ("4 amps", "A", 4.0),
    ("\N{MINUS SIGN}4 mm", "m", -4e-3),
]


@pytest.mark.parametrize(("text", "unit", "value"), VALUES)
def test_a_value_is_read_in_any_notation(text, unit, value):
    assert to_unit(text, unit, "v") == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(("given", "unit"), COMMON)
def test_common_conversions_agree_with_pint_to_the_last_bit(given, unit):
    revolution = 2 * PI if (given, unit) == ("Hz", "rad/s") else 1
    for number in ("1", "0.1", "0.75", "3", "26.7", "-1.23456789e-5"):
        by_pint = registry().Quantity(Fraction(number), parse_unit(given)).to(parse_unit(unit)).magnitude * revolution
        assert to_unit(f"{number} {given}", unit, "v") == float(by_pint)


@pytest.mark.parametrize(
    ("unit", "exponent"), [("s", 0), ("ms", -3), ("us", -6), ("ns", -9), ("ks", 3), ("mm", -3), ("um", -6), ("nm", -9)]
)
def test_a_text_becomes_the_nearest_float(unit, exponent):
    base = unit[-1]
    for digits in ("5", "50", "0.05", "4.7", "1.1", "33.333", "250", "0.3"):
        assert to_unit(f"{digits} {unit}", base, "v") == float(f"{digits}e{exponent}")


def test_an_angle_is_rounded_once():
    for degrees in (7.2, 30.0, 225.0):
        assert to_unit(f"{degrees!r} deg", "rad", "phi") == float(Fraction(repr(degrees)) * PI / 180)
    assert to_unit("90 deg", "rad", "phi") == math.pi / 2
    assert to_unit("60 rpm", "rad/s", "Omega") == to_unit("1 Hz", "rad/s", "Omega") == 2 * math.pi


@pytest.mark.parametrize("text", ["1e999999999 us", f"0.{'1' * 6000} us", "-1e-999999999 us", "0e999999999 us"])
def test_numbers_of_many_digits_are_read_quickly(text):
    begin = time.process_time()
    with suppress(ValueError):
        assert abs(to_unit(text, "s", "t")) < 1e-6
    assert time.process_time() - begin < 1.0


@pytest.mark.parametrize("case", [str.lower, str.title, str.upper])
@pytest.mark.parametrize(
    ("name", "unit", "value"),
    [
        *(("newton", "N", 1.0), ("kilonewtons", "N", 1e3), ("lbf", "N", 4.4482216152605), ("newton metre", "N.m", 1.0)),
        *(
            ("volt", "V", 1.0),
            ("ampere", "A", 1.0),
            ("milliamps", "A", 1e-3),
            ("ohms", "Ohm", 1.0),
            ("tesla", "T", 1.0),
        ),
        *(("meter", "m", 1.0), ("millimetres", "m", 1e-3), ("inches", "m", 0.0254), ("mils", "m", 25.4e-6)),
        *(("second", "s", 1.0), ("hertz", "Hz", 1.0), ("kilohertz", "Hz", 1e3), ("minutes", "s", 60.0)),
        *(("pascal", "N/m2", 1.0), ("psi", "N/m2", 6894.757293168361), ("kilogramme", "kg", 1.0)),
        *(("rpm", "rad/s", math.pi / 30.0), ("radians/second", "rad/s", 1.0), ("rev/min", "rad/s", math.pi / 30.0)),
        *(("newton/metre", "N/m", 1.0), ("degrees", "rad", math.pi / 180.0), ("henries", "H", 1.0)),
        *(("percent", "1", 0.01), ("lb", "kg", 0.45359237)),
        # products, and German names
        *(("newtonmeter", "N.m", 1.0), ("kilonewtonmetres", "N.m", 1e3), ("newtonmeter/radian", "N.m/rad", 1.0)),
        *(("newtonsekunde", "N.s", 1.0), ("newtonsecond/meter", "N.s/m", 1.0), ("voltampere", "W", 1.0)),
        *(("pascalsekunde", "N.s/m2", 1.0), ("kilowattstunden", "J", 3.6e6), ("newtonmetersekunden", "N.m.s", 1.0)),
        *(("newtonmeter2", "N.m2", 1.0), ("weber", "V.s", 1.0), ("kilopond", "N", 9.80665)),
        *(("poise", "N.s/m2", 0.1), ("centipoise", "N.s/m2", 1e-3), ("stokes", "m2/s", 1e-4), ("dyne", "N", 1e-5)),
        *(("torr", "N/m2", 101325.0 / 760.0), ("gauss", "T", 1e-4), ("kilogauss", "T", 0.1)),
        *(("hp", "W", 745.69987158227022), ("liter/min", "m3/s", 1e-3 / 60.0), ("zoll", "m", 0.0254)),
        *(("kilogramm", "kg", 1.0), ("mikrometer", "m", 1e-6), ("zentimeter", "m", 0.01), ("stunden", "s", 3600.0)),
        *(("umdrehungen/min", "rad/s", math.pi / 30.0), ("upm", "rad/s", math.pi / 30.0)),
    ],
)
def test_names_of_units_are_read_in_any_case(name, unit, value, case):
    assert to_unit(f"3 {case(name)}", unit, "x") == pytest.approx(3.0 * value, rel=1e-12)


AMBIGUOUS = [  # Grad would be 1e9 rad, a prefix and a unit; gr a grain of 65 mg; a ton that of the USA
    *((text, "rad", "deg or gon") for text in ("90 Grad", "90 grad")),
    *(("20 Grad Celsius", "K", "deg or gon"), ("25 gr.mm", "kg.m", "g or grain")),
    ("2 tons", "kg", "t, short_ton or long_ton"),
]
WRONG_CASE = [
    *(("KN", "N", "kN"), ("MM", "m", "mm"), ("HZ", "Hz", "Hz"), ("Kg", "kg", "kg"), ("N/MM", "N/m", "mm")),
    ("a", "A", "A"),
]
MASSES = [("5 kg", "N", "kgf"), ("5 kg-cm", "N.m", "kgf-cm"), ("5 kg/mm", "N/m", "kgf/mm")]  # a kilogram is no force
REFUSED = [
    *((text, unit, ("x", meant)) for text, unit, meant in AMBIGUOUS),
    *((f"3 {text}", unit, (f"'3 {text}'", "case", right)) for text, unit, right in WRONG_CASE),
    ("3 Mw", "W", ("Mw", "MW or mW")),
    *((text, unit, ("x", repr(text), unit, f"as in {force}")) for text, unit, force in MASSES),
    *((f"3 {unit}", "m", ("x", f"unit {unit}", "m")) for unit in ("count", "counts", "bit")),
    # turns of a coil are no angle: 36 were 226, 36 times 2 pi
    *((f"36 {unit}", "1", (f"x = '36 {unit}'", unit, "without a unit")) for unit in ("turn", "turns", "rev")),
    ("3 furlonk", "m", ("x", "'furlonk'", "SI")),
    ("3 s", "m", ("x", "'3 s'", "unit s", "m")),
    *((text, "m", ("x=0.5", "x='0.5 m'")) for text in ("", "mm", "three mm")),
    *((text, "1", ("x",)) for text in ("1e400", "much")),
]


@pytest.mark.parametrize(("text", "unit", "facts"), REFUSED)
def test_a_text_without_a_value_in_the_unit_is_refused_with_what_is_allowed(text, unit, facts):
    with raises_naming(ValueError, *facts) as refused:
        to_unit(text, unit, "x")
    assert not re.search(r"\d 1\b", str(refused.value)), "a number without dimension has no unit"


@pytest.mark.parametrize(
    ("text", "forms"),
    [
        ("12,000 rpm", ("12000", "12.000")),
        ("1,5 rpm", ("1.5",)),
        ("0,750 rpm", ("0.750",)),
        ("12,0000 rpm", ("12.0000",)),
        ("-1.234,5 rpm", ("-1234.5",)),
        ("1,234,567.8 rpm", ("1234567.8",)),
        ("12 000 1/min", ("12000",)),
        ("12'000 rpm", ("12000",)),
        ("12_000 rpm", ("12000",)),
        ("3x10^4 rpm", ("3e4",)),
        ("3·10⁻⁴ rpm", ("3e-4",)),
        ("1,5", ("1.5",)),
    ],
)
def test_a_number_with_separators_is_refused_with_its_plain_forms(text, forms):
    with pytest.raises(ValueError, match="is not allowed") as caught:
        to_unit(text, "rad/s", "speed")
    assert_names(caught.value, "speed", repr(text))
    assert str(caught.value).rpartition("write ")[2] == " or ".join(forms)


@pytest.mark.parametrize(("unit", "name", "value", "shown"), [
    ("rad/s", "rpm", 100.0 * math.pi, 3000.0),
    ("rad", "deg", math.pi, 180.0),
    ("m", "um", 0.75e-3, 750.0),
    ("kg.m", "g.mm", 25e-3, 25000.0),
    ("K", "degC", 293.15, 20.0),
    ("N/m", "N/um", 2e6, 2.0),
])  # fmt: skip
def test_display_units_scale_values_as_customary(unit, name, value, shown):
    conversion = display_unit(unit, name)
    assert conversion["factor"] * value + conversion.get("offset", 0.0) == pytest.approx(shown)


def test_a_unit_that_fmi_cannot_state_and_one_of_another_dimension_are_refused():
    with raises_naming(ValueError, "fractional exponent"):
        base_unit("statcoulomb")
    with raises_naming(ValueError, "rad/s"):
        display_unit("rad/s", "mm")


def test_every_usual_display_unit_can_be_converted():
    assert all(display_unit(unit, name)["factor"] > 0.0 for unit, name in DISPLAYED.items())


AMBIGUOUS = [
    *((f"100 {spelled}", "rad/s", ("100 rad/s", "100 Hz")) for spelled in RECIPROCAL),
    ("0.1 1/ms", "rad/s", ("100 rad/s", "100 Hz")),
    ("3 1/s2", "rad/s2", ("3 rad/s2", "3 turn/s2")),
    ("7 rad/s", "1/s", ("7 1/s", f"{7 / (2 * math.pi):.9g} 1/s")),
    ("60 rpm", "1/s", (f"{2 * math.pi:.9g} 1/s", "1 1/s")),
]


@pytest.mark.parametrize(("text", "unit", "readings"), AMBIGUOUS)
def test_a_reciprocal_second_is_refused_for_an_angular_velocity_with_both_readings(text, unit, readings):
    """100 1/s was taken for 628 rad/s, while 1/s of a rate of growth is 1/s."""
    with raises_naming(ValueError, "speed", *readings):
        to_unit(text, unit, "speed")
    radians, revolutions = (to_unit(reading, unit, "speed") for reading in readings)
    ratio = revolutions / radians
    assert ratio == pytest.approx(2 * math.pi) or 1 / ratio == pytest.approx(2 * math.pi)
