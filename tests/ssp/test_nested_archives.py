"""Archives of nested systems: values, units and laws on the way from connector to connector, in gains y = k u."""

from __future__ import annotations

import json
import sys
import zipfile

import gain_archives
import pytest
from click.testing import CliRunner
from gain_archives import bind, connect, connector, gain, structure, system

import amb_cosim
from amb_cosim.commands.cli import main
from amb_cosim.cosim.ssp import load_ssp
from tests.support.messages import assert_names, raises_naming

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")

UNITS = {"Plain": None, "Metres": "m", "Millimetres": "mm", "Celsius": "degC", "Fahrenheit": "degF", "Newtons": "N",
         "Furlongs": "furlong", "Counts": "count"}  # fmt: skip


@pytest.fixture(scope="module")
def fmus(fmu_from_c, tmp_path_factory):
    compiled, folder = fmu_from_c(gain_archives.SOURCE, gain_archives.description()), tmp_path_factory.mktemp("gains")
    return {name: gain_archives.write_fmu(folder / f"{name}.fmu", compiled, unit) for name, unit in UNITS.items()}


@pytest.fixture
def archive(fmus, tmp_path):
    """`archive(root, units=(), files={})`: an archive with that system and more files."""

    def write(root, units=(), files=None, name="gains.ssp"):
        with zipfile.ZipFile(tmp_path / name, "w") as content:
            content.writestr("SystemStructure.ssd", structure(root, units))
            for fmu, path in fmus.items():
                if f"{fmu}.fmu" in root or files:
                    content.write(path, f"resources/{fmu}.fmu")
            for file, text in (files or {}).items():
                content.writestr(file, text)
        return tmp_path / name

    return write


@pytest.fixture
def last(archive):
    """`last(root, **more)`: the last value of every variable."""

    def run(root, set=None, **more):
        dataset = amb_cosim.simulate(archive(root, **more), set=set, isolated=False).dataset
        return {name: dataset[name].values[-1] for name in dataset}

    return run


LAW = '<ssc:LinearTransformation factor="{}" offset="{}"/>'
IN = connector("In", "input")


def test_a_connector_of_the_system_has_the_value_of_its_parameter_set(last):
    """OMSimulator issue 729: In = -20 feeds a.u, and a.k = 3."""
    values = last(system("root", IN, gain("a"), connect("In", "a.u"), bind({"In": -20.0, "a.k": 3.0})))
    assert (values["In"], values["a.y"]) == (-20.0, -60.0)


def test_a_connected_value_counts_more_than_that_of_the_input(last):
    values = last(system("root", IN, gain("a"), connect("In", "a.u"), bind({"In": 5.0, "a.u": 9.0})))
    assert values["a.y"] == 5.0


def test_a_parameter_connector_sets_what_it_is_connected_to(last):
    gains = connector("stiffness", "parameter")
    links = connect("stiffness", "a.k") + connect("stiffness", "b.k", LAW.format(2, 1))
    root = system("root", gains, gain("a") + gain("b"), links, bind({"stiffness": 30.0, "a.k": 10.0}))
    values = last(root)
    assert (values["a.y"], values["b.y"]) == (30.0, 61.0)


def test_a_signal_of_the_system_can_be_set_in_its_own_unit(last):
    """In is in mm, a.u in m, and b.u is twice In plus 3 mm."""
    root = system(
        "root", connector("In", "input", "mm"), gain("a", "Metres") + gain("b", "Millimetres"),
        connect("In", "a.u") + connect("In", "b.u", LAW.format(2, 3)), bind({"In": 5.0}),
    )  # fmt: skip
    assert last(root, units=("mm",)) == {"In": 5.0, "a.y": 0.005, "b.y": 13.0}
    values = last(root, units=("mm",), set={"In": "2 cm"})
    assert (values["In"], values["a.y"], values["b.y"]) == (pytest.approx(20.0), pytest.approx(0.02), 43.0)
    assert last(root, units=("mm",), set={"b.u": "7 mm"})["In"] == 2.0


def test_a_law_says_how_a_connector_without_a_unit_feeds_another_unit(last):
    """In is 2, which is 2 m at a.u and, times 1000, 2000 mm at b.u."""
    elements = gain("a", "Metres") + gain("b", "Millimetres")
    root = system(
        "root", IN, elements, connect("In", "a.u") + connect("In", "b.u", LAW.format(1000, 0)), bind({"In": 2.0})
    )
    assert last(root) == {"In": 2.0, "a.y": 2.0, "b.y": 2000.0}


CHAIN = gain("a", "{}") + gain("b", "{}")


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


@pytest.mark.parametrize(
    ("attributes", "law", "expected"),
    [
        ('suppressUnitConversion="true"', "", 1.0),
        ('suppressUnitConversion="true"', LAW.format(0.001, 0), 0.001),
        ('suppressUnitConversion="1"', LAW.format(2, 5), 7.0),
        ("", LAW.format(2, 5), 5.002),
    ],
)
def test_a_law_follows_the_conversion_of_units_unless_that_is_suppressed(last, attributes, law, expected):
    link = connect("a.y", "b.u", law, attributes)
    assert last(system("root", "", CHAIN.format("Millimetres", "Metres"), link))["b.y"] == pytest.approx(expected)


def test_a_law_can_connect_what_has_no_common_dimension(last):
    link = connect("a.y", "b.u", LAW.format(0.5, 0))
    assert last(system("root", "", CHAIN.format("Newtons", "Metres"), link))["b.y"] == 0.5


INNER = system(
    "axle", connector("In", "input") + connector("Out", "output") + connector("gain", "parameter"),
    gain("motor"), connect("In", "motor.u") + connect("motor.y", "Out") + connect("gain", "motor.k"),
    bind({"In": 2.0, "gain": 3.0}),
)  # fmt: skip


def test_nested_systems_are_one_system_with_the_paths_as_names(last, archive):
    root = system("root", "", INNER + gain("load"), connect("axle.Out", "load.u"))
    assert last(root) == {"axle.motor.u": 2.0, "axle.motor.y": 6.0, "load.y": 6.0}
    (link,) = load_ssp(archive(root))[0].connections
    assert (link.source, link.target) == ("axle.motor.y", "load.u")


OUT = connector("Out", "output", "mm")


def test_an_output_of_the_archive_is_recorded_in_its_own_unit(archive):
    """a.y is 3 m, which are 3000 mm at Out, and 6.5 without a unit at Twice, after twice and 0.5 more."""
    ends = OUT + connector("Plain", "output") + connector("Twice", "output")
    links = connect("a.y", "Out") + connect("a.y", "Plain") + connect("a.y", "Twice", LAW.format(2, 0.5))
    root = system("root", ends, gain("a", "Metres"), links, bind({"a.k": 3.0}))
    dataset = amb_cosim.simulate(archive(root, units=("mm",)), isolated=False).dataset
    assert {name: (dataset[name].values[-1], dataset[name].attrs["units"]) for name in dataset} == {
        "a.y": (3.0, "m"), "Out": (3000.0, "mm"), "Plain": (3.0, "m"), "Twice": (6.5, "1"),
    }  # fmt: skip


def test_outputs_of_nested_systems_reach_those_of_the_archive(last):
    """axle.Out is 6; the archive shows it directly, and behind a gain that it feeds."""
    ends = connector("torque", "output") + connector("load", "output")
    links = connect("axle.Out", "torque") + connect("axle.Out", "load.u") + connect("load.y", "load")
    values = last(system("root", ends, INNER + gain("load"), links, bind({"load.k": 2.0})))
    assert (values["torque"], values["load"]) == (6.0, 12.0)


def test_an_input_of_the_archive_may_also_be_its_output(last):
    root = system("root", IN + OUT, gain("a"), connect("In", "a.u") + connect("In", "Out"), bind({"In": 5.0}))
    assert last(root, units=("mm",)) == {"In": 5.0, "Out": 5.0, "a.y": 5.0}


def test_an_output_that_shows_nothing_is_left_out(last):
    ends = OUT + connector("time", "output")
    assert last(system("root", ends, gain("a"), connect("a.y", "time")), units=("mm",)) == {"a.y": 1.0}


def test_values_of_an_outer_system_count_more(last):
    root = system("root", "", INNER, bindings=bind({"axle.In": 5.0, "axle.motor.k": 100.0, "axle.gain": 7.0}))
    assert last(root)["axle.motor.y"] == 35.0


def test_a_variable_of_a_nested_component_can_be_set_by_its_path(last):
    values = last(system("root", "", INNER), set={"axle.motor.k": 11.0})
    assert values["axle.motor.y"] == 22.0


def test_units_are_converted_at_each_connector_on_the_way(last):
    """1 m as a.y is 1000 mm at the connector and, after twice and 500 mm more, 2.5 m at b.u."""
    inner = system("box", connector("In", "input", "mm"), gain("b", "Metres"), connect("In", "b.u"))
    root = system("root", "", gain("a", "Metres") + inner, connect("a.y", "box.In", LAW.format(2, 500)))
    assert last(root, units=("mm",))["box.b.y"] == pytest.approx(2.5)


DICTIONARY = """<ssd:SignalDictionaries><ssd:SignalDictionary name="bus"{0}></ssd:SignalDictionaries>"""
ENTRIES = f"""<ssb:SignalDictionary {gain_archives.NAMESPACES} version="1.0">
<ssb:DictionaryEntry name="height"><ssc:Real unit="mm"/></ssb:DictionaryEntry>
<ssb:Units><ssc:Unit name="mm"><ssc:BaseUnit m="1" factor="0.001"/></ssc:Unit></ssb:Units></ssb:SignalDictionary>"""
INLINE = DICTIONARY.format(f">{ENTRIES}</ssd:SignalDictionary")
REFERENCE = """<ssd:SignalDictionaryReference name="wires" dictionary="bus"><ssd:Connectors>
<ssd:Connector name="height" kind="inout"><ssc:Real/></ssd:Connector></ssd:Connectors>
</ssd:SignalDictionaryReference>"""


@pytest.mark.parametrize("is_inline", [True, False])
def test_an_entry_of_a_signal_dictionary_connects_systems(last, is_inline):
    """Two references in different systems lead to one entry, which is looked up in the outer system."""
    reader = system("reader", "", gain("b") + REFERENCE, connect("wires.height", "b.u"))
    root = system(
        "root", "", gain("a", "Metres") + REFERENCE + reader, connect("a.y", "wires.height"), bind({"a.k": 3.0}),
        INLINE if is_inline else DICTIONARY.format(' source="extra/bus.ssb"/'),
    )  # fmt: skip
    values = last(root, files={} if is_inline else {"extra/bus.ssb": ENTRIES})
    assert values["reader.b.y"] == pytest.approx(3000.0)


ENTRY = '<ssm:MappingEntry source="{}" target="{}">{}</ssm:MappingEntry>'


def test_a_mapping_renames_and_transforms_and_omits_the_rest(last):
    """The numbers are those of OMSimulator's test LinearTransformation3: k = 4 2 + 5, u = 2 2 + 10, y = 182."""
    mapping = ENTRY.format("gain", "a.k", LAW.format(4, 5)) + ENTRY.format("push", "a.u", LAW.format(2, 10))
    mapping += ENTRY.format("absent", "b.u", "")
    values = last(
        system("root", "", gain("a") + gain("b"), bindings=bind({"gain": 2.0, "push": 2.0, "b.k": 9.0}, mapping))
    )
    assert (values["a.y"], values["b.y"]) == (182.0, 1.0)


def test_a_mapping_converts_units_before_its_law(last):
    value = '<ssv:Real value="2" unit="m"/>'
    for attributes, expected in (("", 2001.0), ('suppressUnitConversion="true"', 3.0)):
        mapping = ENTRY.format("push", f'a.u" {attributes} description="', LAW.format(1, 1))
        root = system("root", "", gain("a", "Millimetres"), bindings=bind({"push": value}, mapping))
        assert last(root, units=("m", "mm"))["a.y"] == expected


def test_units_of_values_may_be_in_brackets_or_a_dash(last):
    values = {"a.u": '<ssv:Real value="2" unit="[m]"/>', "a.k": '<ssv:Real value="3" unit="-"/>'}
    assert last(system("root", "", gain("a", "Millimetres"), bindings=bind(values)), units=("m",))["a.y"] == 6000.0


def test_mappings_and_sets_can_be_files_and_have_a_prefix(last):
    sets = f'<ssv:ParameterSet {gain_archives.NAMESPACES} version="1.0" name="s"><ssv:Parameters>'
    sets += '<ssv:Parameter name="gain"><ssv:Real value="2"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>'
    mapping = f'<ssm:ParameterMapping {gain_archives.NAMESPACES} version="1.0">'
    mapping += f"{ENTRY.format('my.gain', 'a.k', '')}</ssm:ParameterMapping>"
    bound = '<ssd:ParameterBindings><ssd:ParameterBinding prefix="my." source="resources/s.ssv">'
    bound += '<ssd:ParameterMapping source="m.ssm"/></ssd:ParameterBinding></ssd:ParameterBindings>'
    values = last(system("root", "", gain("a"), bindings=bound), files={"resources/s.ssv": sets, "m.ssm": mapping})
    assert values["a.y"] == 2.0


def test_a_system_can_be_a_document_or_an_archive_of_its_own(last, archive, fmus, tmp_path):
    inner = structure(INNER.replace('name="axle"', 'name="own"'))
    for kind, source in (("definition", "axle.ssd"), ("package", "axle.ssp")):
        content = inner
        if kind == "package":
            archive(INNER, name="axle.ssp")
            content = (tmp_path / "axle.ssp").read_bytes()
        element = f'<ssd:Component name="axle" type="application/x-ssp-{kind}" source="{source}">{bind({"In": 4.0})}'
        root = system("root", "", f"{element}</ssd:Component>{gain('load')}", connect("axle.Out", "load.u"))
        assert last(root, files={source: content})["load.y"] == 12.0


PART = '<ssd:Component name="x" type="application/x-ssp-{}" source="{}">{}</ssd:Component>'
SIX = f"""<ssv:ParameterSet {gain_archives.NAMESPACES} version="1.0" name="s"><ssv:Parameters>
<ssv:Parameter name="n.k"><ssv:Real value="6"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>"""
INSIDE = """<ssd:ParameterBindings><ssd:ParameterBinding sourceBase="component" source="six.ssv"/>
</ssd:ParameterBindings>"""


@pytest.mark.parametrize("source", ["Plain.fmu", "./Plain.fmu", "../resources/Plain.fmu", r"..\resources\Plain.fmu"])
def test_sources_are_relative_to_the_document_that_names_them(last, archive, fmus, source):
    """Also with the backslashes of Windows; a source outside the archive is refused."""
    files = {"sub/axle.ssd": structure(system("axle", "", gain("m").replace("resources/Plain.fmu", source)))}
    files["sub/Plain.fmu"] = fmus["Plain"].read_bytes()
    root = system("root", "", PART.format("definition", "sub/axle.ssd", "") + gain("z"))
    assert last(root, files=files)["x.m.y"] == 1.0
    files["sub/axle.ssd"] = files["sub/axle.ssd"].replace(source, "../../Plain.fmu")
    with raises_naming(ValueError, "sub/axle.ssd", "../../Plain.fmu"):
        load_ssp(archive(root, files=files))


def test_a_system_can_be_used_again_by_its_id(last, archive):
    """The system has y = 3 u; the second one gets the output of the first."""
    axle = INNER.replace('name="axle"', 'name="axle" id="a1"', 1)
    root = system("root", "", axle + PART.format("definition", "#a1", ""), connect("axle.Out", "x.In"))
    values = last(root)
    assert (values["axle.motor.y"], values["x.motor.y"]) == (6.0, 18.0)
    with raises_naming(ValueError, "'a2'", "a1"):
        load_ssp(archive(root.replace("#a1", "#a2")))


def test_an_archive_in_an_archive_may_have_several_systems_and_sets(last, archive, fmus, tmp_path):
    with zipfile.ZipFile(archive(system("default", "", gain("n")), name="sub.ssp"), "a") as sub:
        sub.writestr("other.ssd", structure(system("other", "", gain("n"), "", bind({"n.k": 5.0}))))
        sub.writestr("six.ssv", SIX)
    files = {"sub.ssp": (tmp_path / "sub.ssp").read_bytes()}
    for source, bound, expected in (("sub.ssp", "", 1.0), ("sub.ssp#other.ssd", "", 5.0), ("sub.ssp", INSIDE, 6.0)):
        root = system("root", "", PART.format("package", source, bound) + gain("z"))
        assert last(root, files=files)["x.n.y"] == expected
    with raises_naming(ValueError, "sub.ssp", "'none.ssd'"):
        load_ssp(archive(root.replace('"sub.ssp"', '"sub.ssp#none.ssd"'), files=files))


@pytest.mark.parametrize("empty", ["ParameterBindings", "Connectors", "Elements", "Connections", "Annotations"])
def test_an_empty_group_is_none(last, empty):
    order = ("Connectors", "ParameterBindings", "Elements", "Connections", "Annotations")
    inner = "".join(f"<ssd:{name}/>" for name in order if name == empty)
    assert last(system("root", "", gain("a") + f'<ssd:System name="e">{inner}</ssd:System>'))["a.y"] == 1.0


def test_the_order_of_groups_has_no_meaning(last):
    """As in an archive of OMSimulator's tests, with annotations and connectors behind the elements."""
    parts = f"<ssd:Annotations/><ssd:Elements>{gain('a')}</ssd:Elements><ssd:Connectors>{IN}</ssd:Connectors>"
    links = f"<ssd:Connections>{connect('In', 'a.u')}</ssd:Connections>"
    assert last(f'<ssd:System name="root">{links}{parts}{bind({"In": 3.0, "a.k": 2.0})}</ssd:System>')["a.y"] == 6.0


def test_a_component_that_requests_model_exchange_runs_with_a_notice(archive):
    element = gain("a").replace("<ssd:Component", '<ssd:Component implementation="ModelExchange"')
    result = amb_cosim.simulate(archive(system("root", "", element))).dataset
    (notice,) = json.loads(result.attrs["notices"])
    assert_names(notice, "a", "model exchange", "co-simulation")


BOOLEANS = """<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>
</ssc:BooleanMappingTransformation>"""
TRUE = bind({"x": "<ssv:Boolean value='true'/>"}, ENTRY.format("x", "a.k", LAW.format(2, 2)))
FORCE = bind({"a.u": '<ssv:Real value="1" unit="N"/>'})
SCRIPT = gain("a").replace("<ssd:Component", '<ssd:Component type="text/x-script"')
LOOP = '<ssd:Component name="self" type="application/x-ssp-definition" source="SystemStructure.ssd"/>'


@pytest.mark.parametrize(
    ("elements", "links", "bindings", "facts"),
    [
        (CHAIN.format("Newtons", "Metres"), ["a.y b.u"], "", ("a.y", "N", "b.u", "m")),
        (CHAIN.format("Counts", "Metres"), ["a.y b.u"], "", ("count", "m")),
        (CHAIN.format("Millimetres", "Metres"), ["In a.u", "In b.u"], "", ("In", "mm", "m")),
        (gain("a"), ["a.y c.u"], "", ("'c'", "a")),
        (gain("a"), ["In a.v"], bind({"In": 1.0}), ("a", "'v'", "u")),
        (gain("a"), ["Im a.u"], "", ("the system", "'Im'", "In")),
        (system("axle", connector("In", "input"), gain("a")), ["In axle.Out"], "", ("axle", "'Out'", "In")),
        (system("box"), [], "", ("no component",)),
        (gain("a.b"), [], "", ("a.b", "dot")),
        (gain("a") + gain("a"), [], "", ("a", "two")),
        (gain("a") + gain("b"), ["a.y b.y"], "", ("a.y", "b.y", "outputs")),
        (gain("a") + gain("b"), ["a.k b.k"], "", ("b.k", "a parameter", "input")),
        (gain("a") + gain("b"), [f"a.y b.u {BOOLEANS}"], "", ("BooleanMappingTransformation",)),
        (gain("a") + REFERENCE, [], "", ("wires", "'bus'")),
        (gain("a", "Metres"), [], FORCE, ("a.u", "N", "m")),
        (gain("a"), [], TRUE, ("a.k", "number")),
        (LOOP, [], "", ("nested", "20")),
        (SCRIPT, [], "", ("a", "text/x-script")),
    ],
)
def test_what_cannot_be_connected_is_refused_with_its_names(archive, elements, links, bindings, facts):
    connections = "".join(connect(*link.split(maxsplit=2)) for link in links)
    with raises_naming(ValueError, *facts):
        amb_cosim.simulate(archive(system("root", IN, elements, connections, bindings)), isolated=False)


def test_a_set_can_be_among_the_resources_of_an_fmu(archive, fmus, tmp_path):
    sets = f'<ssv:ParameterSet {gain_archives.NAMESPACES} version="1.0" name="s"><ssv:Parameters>'
    sets += '<ssv:Parameter name="k"><ssv:Real value="6"/></ssv:Parameter></ssv:Parameters></ssv:ParameterSet>'
    (tmp_path / "Own.fmu").write_bytes(fmus["Plain"].read_bytes())
    with zipfile.ZipFile(tmp_path / "Own.fmu", "a") as own:
        own.writestr("resources/own.ssv", sets)
    bound = '<ssd:ParameterBindings><ssd:ParameterBinding sourceBase="component" source="own.ssv"/>'
    root = system("root", "", gain("a", "Own", f"{bound}</ssd:ParameterBindings>"))
    path = archive(root, files={"resources/Own.fmu": (tmp_path / "Own.fmu").read_bytes()})
    assert amb_cosim.simulate(path, isolated=False).dataset["a.y"].values[-1] == 6.0


def test_a_value_of_an_output_is_refused(archive):
    with raises_naming(ValueError, "a.y", "an output"):
        amb_cosim.simulate(archive(system("root", "", gain("a"), bindings=bind({"a.y": 1.0}))))


def test_tables_of_a_mapping_replace_values(archive):
    """An Integer of a set chooses a gain: 2 becomes 7; what the table lacks is refused."""
    table = '<ssc:IntegerMappingTransformation><ssc:MapEntry source="2" target="7"/></ssc:IntegerMappingTransformation>'
    for value, expected in ((2, 7.0), (3, None)):
        bound = bind({"choice": f'<ssv:Integer value="{value}"/>'}, ENTRY.format("choice", "a.k", table))
        path = archive(system("root", "", gain("a"), bindings=bound))
        if expected is None:
            with raises_naming(ValueError, "a.k", "IntegerMappingTransformation", "3", "2"):
                load_ssp(path)
        else:
            assert load_ssp(path)[0].parameters["a"] == {"k": expected}


def test_variables_of_an_archive_are_plotted_over_time(archive, tmp_path):
    """It has no cycles; what needs a rotor is refused."""
    path = archive(system("root", "", INNER + gain("load"), connect("axle.Out", "load.u")))
    amb_cosim.simulate(path, isolated=False).save(tmp_path / "run")

    def invoke(*arguments):
        return CliRunner().invoke(main, [*map(str, arguments)])

    for variables in (["axle.motor.y"], ["motor.y", "load.*"]):
        assert invoke("plot", tmp_path / "run", *variables, "-o", tmp_path / "y.png").exit_code == 0
    for command in (["plot", tmp_path / "run", "orbits"], ["compare", tmp_path / "run", tmp_path / "run"]):
        refused = invoke(*command)
        assert refused.exit_code == 2
        assert_names(refused.output, "system", "scenario")


def test_a_connector_of_the_system_may_have_a_dot_in_its_name(archive):
    """As those of buses have."""
    bus = connector("Bus.In", "input", "mm")
    link = '<ssd:Connection startConnector="Bus.In" endElement="a" endConnector="u"/>'
    path = archive(system("root", bus, gain("a", "Metres"), link, bind({"Bus.In": 5.0, "a.k": 2.0})), units=("mm",))
    for set, expected in ({}, 5.0), ({"Bus.In": "1 cm"}, 10.0):
        result = amb_cosim.simulate(path, set=set, isolated=False).dataset
        assert result["Bus.In"].values.tolist() == [expected] * 6
        assert result["Bus.In"].attrs["units"] == "mm"
        assert result["a.y"].values.tolist() == pytest.approx([0.002 * expected] * 6)
