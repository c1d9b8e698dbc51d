"""Units, laws and mappings on the way from connector to connector of an archive, in gains y = k u."""

import pytest
from gain_archives import CHAIN, ENTRY, IN, LAW, OUT, bind, connect, connector, gain, system

import amb_cosim
from amb_cosim.cosim.ssp import load_ssp
from tests.support.messages import raises_naming


def test_a_signal_of_the_system_can_be_set_in_its_unit(last):
    """In is in mm, a.u in m, and b.u is twice In plus 3 mm."""
    root = system(
        "root", connector("In", "input", "mm"), gain("a", "Metres") + gain("b", "Millimetres"),
        connect("In", "a.u") + connect("In", "b.u", LAW.format(2, 3)), bind({"In": 5.0}),
    )  # fmt: skip
    assert last(root, units=("mm",)) == {"In": 5.0, "a.y": 0.005, "b.y": 13.0}
    values = last(root, units=("mm",), set={"In": "2 cm"})
    assert (values["In"], values["a.y"], values["b.y"]) == (pytest.approx(20.0), pytest.approx(0.02), 43.0)
    assert last(root, units=("mm",), set={"b.u": "7 mm"})["In"] == 2.0


def test_a_transformation_connects_a_connector_without_unit(last):
    """In is 2, which is 2 m at a.u and, times 1000, 2000 mm at b.u."""
    elements = gain("a", "Metres") + gain("b", "Millimetres")
    root = system(
        "root", IN, elements, connect("In", "a.u") + connect("In", "b.u", LAW.format(1000, 0)), bind({"In": 2.0})
    )
    assert last(root) == {"In": 2.0, "a.y": 2.0, "b.y": 2000.0}


@pytest.mark.parametrize(
    ("source", "target", "k", "expected"),
    [
        ("Millimetres", "Metres", 1.0, 0.001),
        ("Metres", "Millimetres", 3.0, 3000.0),
        ("Furlongs", "Metres", 1.0, 201.168),
        ("Celsius", "Fahrenheit", 100.0, 212.0),
        ("Plain", "Metres", 1.0, 1.0),
        ("Counts", "Counts", 7.0, 7.0),
    ],
)
def test_a_connection_converts_units(last, source, target, k, expected):
    root = system("root", "", CHAIN.format(source, target), connect("a.y", "b.u"), bind({"a.k": k}))
    assert last(root)["b.y"] == pytest.approx(expected, rel=1e-12)


RISE = '<ssv:Real value="18" unit="degF"/>'


def test_a_relative_quantity_is_converted_without_offsets(last):
    """A rise of 18 degrees Fahrenheit is one of 10 degrees Celsius: of a variable, a connector and a value."""
    bound = bind({"a.u": RISE})
    elements = CHAIN.format("FahrenheitRises", "CelsiusRises") + gain("c", "CelsiusRises", bind({"u": RISE}))
    links = connect("a.y", "b.u") + connect("a.y", "Rise")
    values = last(system("root", connector("Rise", "output", "degC"), elements, links, bound), units=("degC", "degF"))
    assert (values["a.y"], values["b.y"], values["c.y"], values["Rise"]) == pytest.approx((18.0, 10.0, 10.0, 10.0))


@pytest.mark.parametrize(
    ("attributes", "law", "expected"),
    [
        ('suppressUnitConversion="true"', "", 1.0),
        ('suppressUnitConversion="true"', LAW.format(0.001, 0), 0.001),
        ('suppressUnitConversion="1"', LAW.format(2, 5), 7.0),
        ("", LAW.format(2, 5), 5.002),
    ],
)
def test_a_transformation_follows_the_unit_conversion_if_not_suppressed(last, attributes, law, expected):
    link = connect("a.y", "b.u", law, attributes)
    assert last(system("root", "", CHAIN.format("Millimetres", "Metres"), link))["b.y"] == pytest.approx(expected)


def test_a_transformation_connects_different_dimensions(last):
    link = connect("a.y", "b.u", LAW.format(0.5, 0))
    assert last(system("root", "", CHAIN.format("Newtons", "Metres"), link))["b.y"] == 0.5


def test_an_output_of_the_archive_is_recorded_in_its_unit(gain_archive):
    """a.y is 3 m, which are 3000 mm at Out, and 6.5 without a unit at Twice, after twice and 0.5 more."""
    ends = OUT + connector("Plain", "output") + connector("Twice", "output")
    links = connect("a.y", "Out") + connect("a.y", "Plain") + connect("a.y", "Twice", LAW.format(2, 0.5))
    root = system("root", ends, gain("a", "Metres"), links, bind({"a.k": 3.0}))
    dataset = amb_cosim.simulate(gain_archive(root, units=("mm",)), isolated=False).dataset
    assert {name: (dataset[name].values[-1], dataset[name].attrs["units"]) for name in dataset} == {
        "a.y": (3.0, "m"), "Out": (3000.0, "mm"), "Plain": (3.0, "m"), "Twice": (6.5, "1"),
    }  # fmt: skip


def test_units_are_converted_at_each_connector_on_the_way(last):
    """1 m as a.y is 1000 mm at the connector and, after twice and 500 mm more, 2.5 m at b.u."""
    inner = system("box", connector("In", "input", "mm"), gain("b", "Metres"), connect("In", "b.u"))
    root = system("root", "", gain("a", "Metres") + inner, connect("a.y", "box.In", LAW.format(2, 500)))
    assert last(root, units=("mm",))["box.b.y"] == pytest.approx(2.5)


def test_a_mapping_renames_transforms_and_omits_the_rest(last):
    """The numbers are those of OMSimulator's test LinearTransformation3: k = 4 2 + 5, u = 2 2 + 10, y = 182."""
    mapping = ENTRY.format("gain", "a.k", LAW.format(4, 5)) + ENTRY.format("push", "a.u", LAW.format(2, 10))
    mapping += ENTRY.format("absent", "b.u", "")
    values = last(
        system("root", "", gain("a") + gain("b"), bindings=bind({"gain": 2.0, "push": 2.0, "b.k": 9.0}, mapping))
    )
    assert (values["a.y"], values["b.y"]) == (182.0, 1.0)


def test_a_mapping_converts_units_before_its_transformation(last):
    value = '<ssv:Real value="2" unit="m"/>'
    for attributes, expected in (("", 2001.0), ('suppressUnitConversion="true"', 3.0)):
        mapping = ENTRY.format("push", f'a.u" {attributes} description="', LAW.format(1, 1))
        root = system("root", "", gain("a", "Millimetres"), bindings=bind({"push": value}, mapping))
        assert last(root, units=("m", "mm"))["a.y"] == expected


def test_units_of_values_may_be_in_brackets_or_a_dash(last):
    values = {"a.u": '<ssv:Real value="2" unit="[m]"/>', "a.k": '<ssv:Real value="3" unit="-"/>'}
    assert last(system("root", "", gain("a", "Millimetres"), bindings=bind(values)), units=("m",))["a.y"] == 6000.0


def test_tables_of_a_mapping_replace_values(gain_archive):
    """An Integer of a set chooses a gain: 2 becomes 7; what the table lacks is refused."""
    table = '<ssc:IntegerMappingTransformation><ssc:MapEntry source="2" target="7"/></ssc:IntegerMappingTransformation>'
    for value, expected in ((2, 7.0), (3, None)):
        bound = bind({"choice": f'<ssv:Integer value="{value}"/>'}, ENTRY.format("choice", "a.k", table))
        path = gain_archive(system("root", "", gain("a"), bindings=bound))
        if expected is None:
            with raises_naming(ValueError, "a.k", "IntegerMappingTransformation", "3", "2"):
                load_ssp(path)
        else:
            assert load_ssp(path)[0].parameters["a"] == {"k": expected}
