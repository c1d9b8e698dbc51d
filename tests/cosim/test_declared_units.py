"""Units that an FMU declares are valid under any name; values may be in any of them."""

from pathlib import Path

import pytest
from fmu_systems import write_system

import amb_cosim
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmu_interface import Port
from amb_cosim.cosim.system.values import convert
from fmi_export.building.number_texts import plain_forms
from tests.support.messages import raises_naming

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Units" guid="{{units}}"><CoSimulation modelIdentifier="gain"/>
<UnitDefinitions>{units}</UnitDefinitions>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1" unit="{unit}"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real unit="{unit}"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure></fmiModelDescription>"""
UNITS = """<Unit name="count"/><Unit name="bit"/><Unit name="tick"/><Unit name="LSB"/>
<Unit name="furlong2"><BaseUnit m="1" factor="200"/></Unit>
<Unit name="stick"><BaseUnit m="1" factor="2"/><DisplayUnit name="half stick" factor="2"/></Unit>
<Unit name="mil"><BaseUnit rad="1" factor="0.001"/></Unit>
<Unit name="rad"><BaseUnit rad="1"/><DisplayUnit name="gon" factor="63.66197723675814"/></Unit>
<Unit name="rad/s"><BaseUnit rad="1" s="-1"/></Unit>
<Unit name="m"><BaseUnit m="1"/></Unit>
<Unit name="warm"><BaseUnit K="1" factor="2" offset="300"/></Unit>
<Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>"""


@pytest.fixture
def port_in(tmp_path):
    """`port_in(unit, changes={}, name="u")`: a variable of an FMU in that unit, with texts in place of others."""

    def read(unit, changes=None, name="u"):
        text = DESCRIPTION.format(units=UNITS, unit=unit)
        for old, new in (changes or {}).items():
            text = text.replace(old, new)
        (tmp_path / "modelDescription.xml").write_text(text, encoding="utf-8")
        return read_interface(tmp_path, "one").ports[name]

    return read


def check_conversion(value, port, expected):
    """The value in the unit of the port, or a refusal that names both units."""
    if expected is None:
        with raises_naming(ValueError, "one.u", port.unit, value.split()[1]):
            convert(value, port, "one.u")
    else:
        assert convert(value, port, "one.u") == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "value", "expected"),
    [
        ("count", "3 count", 3.0),
        ("count", "3 counts", 3.0),
        ("bit", "8 bit", 8.0),
        ("tick", "5 ticks", 5.0),
        ("tick", 5, 5.0),
        ("LSB", "2 LSB", 2.0),
        ("stick", "3 half stick", 1.5),
        ("stick", "1 furlong2", 100.0),
        ("stick", "8 m", 4.0),
        ("furlong2", "1 km", 5.0),
        ("m", "3 stick", 6.0),
        ("mil", "2 mil", 2.0),
        ("mil", "1 deg", 17.453292519943295),
        ("mil", "1 mm", None),
        ("rad", "2 mil", 0.002),
        ("rad", "100 gon", 1.5707963267948966),
        ("rad/s", "60 rpm", 6.283185307179586),
        ("warm", "27 degC", 0.075),
        ("K", "27 degC", 300.15),
        ("m", "3 ms", None),
        ("tick", "3 kg", None),
        ("stick", "3 kg", None),
        ("warm", "3 stick", None),
    ],
)
def test_a_value_may_be_in_any_unit_that_the_fmu_declares(port_in, unit, value, expected):
    check_conversion(value, port_in(unit), expected)


@pytest.mark.parametrize(
    ("unit", "value", "expected"),
    [
        ("K", "10 K", 10.0),
        ("K", "10 degC", 10.0),  # as a display unit that the FMU declares
        ("K", "18 degF", 10.0),
        ("warm", "10 degC", 5.0),
        ("undeclared", "10 degC", None),
        ("degC", "10 K", 10.0),  # which this FMU does not define
        ("m", "3 stick", 6.0),
    ],
)
@pytest.mark.parametrize("of_type", [False, True])
def test_a_relative_quantity_is_converted_without_offsets(port_in, unit, value, expected, of_type):
    """FMI 2.0.4, section 2.2.3: 10 degrees Celsius are 10 K of a relative quantity, not 283.15 K."""
    relative = 'relativeQuantity="true"'
    rise = f'<TypeDefinitions><SimpleType name="Rise"><Real {relative}/></SimpleType></TypeDefinitions>'
    attribute = 'declaredType="Rise"' if of_type else relative
    changes = {'<Real start="1"': f'<Real start="1" {attribute}', "<ModelVariables>": f"{rise}<ModelVariables>"}
    check_conversion(value, port_in(unit, changes), expected)


def test_limits_of_a_type_are_those_of_its_variables(port_in):
    """Except for those that a variable has itself."""
    limited = '<TypeDefinitions><SimpleType name="Gap"><Real min="0" max="3"/></SimpleType></TypeDefinitions>'
    changes = {"<ModelVariables>": f"{limited}<ModelVariables>", 'start="1"': 'start="1" declaredType="Gap"'}
    changes['<Real unit="m"/>'] = '<Real unit="m" declaredType="Gap" max="5"/>'
    u, y = (port_in("m", changes, name) for name in "uy")
    assert [(port.minimum, port.maximum) for port in (u, y)] == [(0.0, 3.0), (0.0, 5.0)]


@pytest.mark.parametrize("value", ["12,000 count", "1,5 counts", "12 000"])
def test_a_number_with_separators_is_refused_in_any_unit(port_in, value):
    with raises_naming(ValueError, "one.u", repr(value), plain_forms(value)[0], "separators"):
        convert(value, port_in("count"), "one.u")


def test_a_system_of_counts_runs(fmu_from_c, tmp_path):
    """An FMU that declares the unit count, without a definition, connected with itself; pint issue 543."""
    source = Path(__file__).parents[1] / "ssp" / "gain.c"
    text = DESCRIPTION.format(units='<Unit name="count"/>', unit="count")
    fmu = fmu_from_c(source, text, name="counting")
    connect = '[[connect]]\nfrom = "adc"\nto = "filter"\nvariables = { y = "u" }\n'
    path = write_system(tmp_path, {"adc": fmu, "filter": fmu}, more=connect)
    result = amb_cosim.simulate(path, set={"adc.u": "3 counts"}, isolated=False)
    assert result.dataset["filter.y"].values[-1] == 3.0
    assert result.dataset["filter.y"].attrs["units"] == "count"


def test_limits_of_unsigned_integers_apply(tmp_path):
    (tmp_path / "modelDescription.xml").write_text(
        """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Counter" instantiationToken="{counter}">
<CoSimulation modelIdentifier="counter"/><ModelVariables>
<UInt8 name="n" valueReference="0" causality="parameter" variability="fixed" start="3" min="2" max="7"/>
<Float64 name="time" valueReference="1" causality="independent" variability="continuous"/>
</ModelVariables><ModelStructure/></fmiModelDescription>""",
        encoding="utf-8",
    )
    port = read_interface(tmp_path, "one").ports["n"]
    assert convert(7, port, "one.n") == 7.0
    with raises_naming(ValueError, "one.n", "8", ">= 2 and <= 7"):
        convert(8, port, "one.n")


def test_a_value_that_an_fmu_fixes_is_named_once():
    port = Port(
        "sample_time", "Real", "parameter", 0, unit="s", minimum=2e-5 * (1.0 - 1e-9), maximum=2e-5 * (1.0 + 1e-9)
    )
    assert convert("20 us", port, "one.sample_time") == 2e-5
    with raises_naming(ValueError, "2.5e-05 s (25 us)", "it must be 2e-05 s"):
        convert("25 us", port, "one.sample_time")
