"""Archives of nested systems: values, units and laws on the way from connector to connector, in gains y = k u."""

import json
import shutil
import zipfile

import gain_archives
import pytest
from gain_archives import (
    CHAIN,
    ENTRY,
    IN,
    LAW,
    OUT,
    bind,
    binding,
    component,
    connect,
    connector,
    gain,
    structure,
    system,
    value_set,
)

import amb_cosim
from amb_cosim.cosim.ssp import load_ssp
from tests.support.changed_archive import changed_archive
from tests.support.messages import assert_names, raises_naming


def test_a_connector_of_the_system_has_the_value_of_its_parameter_set(last):
    """OMSimulator issue 729: In = -20 feeds a.u, and a.k = 3."""
    values = last(system("root", IN, gain("a"), connect("In", "a.u"), bind({"In": -20.0, "a.k": 3.0})))
    assert (values["In"], values["a.y"]) == (-20.0, -60.0)


def test_a_connected_value_overrides_that_of_the_input(last):
    values = last(system("root", IN, gain("a"), connect("In", "a.u"), bind({"In": 5.0, "a.u": 9.0})))
    assert values["a.y"] == 5.0


def test_a_parameter_connector_sets_the_connected_parameters(last):
    gains = connector("stiffness", "parameter")
    links = connect("stiffness", "a.k") + connect("stiffness", "b.k", LAW.format(2, 1))
    root = system("root", gains, gain("a") + gain("b"), links, bind({"stiffness": 30.0, "a.k": 10.0}))
    values = last(root)
    assert (values["a.y"], values["b.y"]) == (30.0, 61.0)


INNER = system(
    "axle", connector("In", "input") + connector("Out", "output") + connector("gain", "parameter"),
    gain("motor"), connect("In", "motor.u") + connect("motor.y", "Out") + connect("gain", "motor.k"),
    bind({"In": 2.0, "gain": 3.0}),
)  # fmt: skip


def test_nested_systems_are_one_system_with_the_paths_as_names(last, gain_archive):
    root = system("root", "", INNER + gain("load"), connect("axle.Out", "load.u"))
    assert last(root) == {"axle.motor.u": 2.0, "axle.motor.y": 6.0, "load.y": 6.0}
    (link,) = load_ssp(gain_archive(root))[0].connections
    assert (link.source, link.target) == ("axle.motor.y", "load.u")


def test_outputs_of_nested_systems_reach_those_of_the_archive(last):
    """axle.Out is 6; the archive shows it directly, and behind a gain that it feeds."""
    ends = connector("torque", "output") + connector("load", "output")
    links = connect("axle.Out", "torque") + connect("axle.Out", "load.u") + connect("load.y", "load")
    values = last(system("root", ends, INNER + gain("load"), links, bind({"load.k": 2.0})))
    assert (values["torque"], values["load"]) == (6.0, 12.0)


def test_an_input_of_the_archive_may_also_be_its_output(last):
    root = system("root", IN + OUT, gain("a"), connect("In", "a.u") + connect("In", "Out"), bind({"In": 5.0}))
    assert last(root, units=("mm",)) == {"In": 5.0, "Out": 5.0, "a.y": 5.0}


def test_an_unconnected_output_is_left_out(last):
    ends = OUT + connector("time", "output")
    assert last(system("root", ends, gain("a"), connect("a.y", "time")), units=("mm",)) == {"a.y": 1.0}


def test_values_of_an_outer_system_take_precedence(last):
    root = system("root", "", INNER, bindings=bind({"axle.In": 5.0, "axle.motor.k": 100.0, "axle.gain": 7.0}))
    assert last(root)["axle.motor.y"] == 35.0


def test_a_variable_of_a_nested_component_can_be_set_by_its_path(last):
    values = last(system("root", "", INNER), set={"axle.motor.k": 11.0})
    assert values["axle.motor.y"] == 22.0


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
    """Two references in different systems resolve to one entry of the outer system."""
    reader = system("reader", "", gain("b") + REFERENCE, connect("wires.height", "b.u"))
    root = system(
        "root", "", gain("a", "Metres") + REFERENCE + reader, connect("a.y", "wires.height"), bind({"a.k": 3.0}),
        INLINE if is_inline else DICTIONARY.format(' source="extra/bus.ssb"/'),
    )  # fmt: skip
    values = last(root, files={} if is_inline else {"extra/bus.ssb": ENTRIES})
    assert values["reader.b.y"] == pytest.approx(3000.0)


def test_mappings_and_sets_can_be_files_and_have_a_prefix(last):
    mapping = f'<ssm:ParameterMapping {gain_archives.NAMESPACES} version="1.0">'
    mapping += f"{ENTRY.format('my.gain', 'a.k', '')}</ssm:ParameterMapping>"
    bound = binding('<ssd:ParameterMapping source="m.ssm"/>', 'prefix="my." source="resources/s.ssv"')
    files = {"resources/s.ssv": value_set({"gain": 2.0}), "m.ssm": mapping}
    assert last(system("root", "", gain("a"), bindings=bound), files=files)["a.y"] == 2.0


def test_a_system_can_be_a_separate_document_or_archive(last, gain_archive, gains, tmp_path):
    inner = structure(INNER.replace('name="axle"', 'name="own"'))
    for kind, source in (("definition", "axle.ssd"), ("package", "axle.ssp")):
        content = inner
        if kind == "package":
            gain_archive(INNER, name="axle.ssp")
            content = (tmp_path / "axle.ssp").read_bytes()
        element = f'<ssd:Component name="axle" type="application/x-ssp-{kind}" source="{source}">{bind({"In": 4.0})}'
        root = system("root", "", f"{element}</ssd:Component>{gain('load')}", connect("axle.Out", "load.u"))
        assert last(root, files={source: content})["load.y"] == 12.0


PART = '<ssd:Component name="x" type="application/x-ssp-{}" source="{}">{}</ssd:Component>'
INSIDE = binding("", 'sourceBase="component" source="six.ssv"')


@pytest.mark.parametrize("source", ["Plain.fmu", "./Plain.fmu", "../resources/Plain.fmu", r"..\resources\Plain.fmu"])
def test_sources_are_relative_to_the_document_that_names_them(last, gain_archive, gains, source):
    """Also with the backslashes of Windows; a source outside the archive is refused."""
    files = {"sub/axle.ssd": structure(system("axle", "", gain("m").replace("resources/Plain.fmu", source)))}
    files["sub/Plain.fmu"] = gains["Plain"].read_bytes()
    root = system("root", "", PART.format("definition", "sub/axle.ssd", "") + gain("z"))
    assert last(root, files=files)["x.m.y"] == 1.0
    files["sub/axle.ssd"] = files["sub/axle.ssd"].replace(source, "../../Plain.fmu")
    with raises_naming(ValueError, "sub/axle.ssd", "../../Plain.fmu"):
        load_ssp(gain_archive(root, files=files))


def test_a_system_can_be_reused_by_its_id(last, gain_archive):
    """The system has y = 3 u; the second one gets the output of the first."""
    axle = INNER.replace('name="axle"', 'name="axle" id="a1"', 1)
    root = system("root", "", axle + PART.format("definition", "#a1", ""), connect("axle.Out", "x.In"))
    values = last(root)
    assert (values["axle.motor.y"], values["x.motor.y"]) == (6.0, 18.0)
    with raises_naming(ValueError, "'a2'", "a1"):
        load_ssp(gain_archive(root.replace("#a1", "#a2")))


def test_an_archive_in_an_archive_may_have_several_systems_and_sets(last, gain_archive, gains, tmp_path):
    with zipfile.ZipFile(gain_archive(system("default", "", gain("n")), name="sub.ssp"), "a") as sub:
        sub.writestr("other.ssd", structure(system("other", "", gain("n"), "", bind({"n.k": 5.0}))))
        sub.writestr("six.ssv", value_set({"n.k": 6.0}))
    files = {"sub.ssp": (tmp_path / "sub.ssp").read_bytes()}
    for source, bound, expected in (("sub.ssp", "", 1.0), ("sub.ssp#other.ssd", "", 5.0), ("sub.ssp", INSIDE, 6.0)):
        root = system("root", "", PART.format("package", source, bound) + gain("z"))
        assert last(root, files=files)["x.n.y"] == expected
    with raises_naming(ValueError, "sub.ssp", "'none.ssd'"):
        load_ssp(gain_archive(root.replace('"sub.ssp"', '"sub.ssp#none.ssd"'), files=files))


@pytest.mark.parametrize("empty", ["ParameterBindings", "Connectors", "Elements", "Connections", "Annotations"])
def test_an_empty_group_is_ignored(last, empty):
    order = ("Connectors", "ParameterBindings", "Elements", "Connections", "Annotations")
    inner = "".join(f"<ssd:{name}/>" for name in order if name == empty)
    assert last(system("root", "", gain("a") + f'<ssd:System name="e">{inner}</ssd:System>'))["a.y"] == 1.0


def test_the_order_of_groups_has_no_meaning(last):
    """As in an archive of OMSimulator's tests, with annotations and connectors behind the elements."""
    parts = f"<ssd:Annotations/><ssd:Elements>{gain('a')}</ssd:Elements><ssd:Connectors>{IN}</ssd:Connectors>"
    links = f"<ssd:Connections>{connect('In', 'a.u')}</ssd:Connections>"
    assert last(f'<ssd:System name="root">{links}{parts}{bind({"In": 3.0, "a.k": 2.0})}</ssd:System>')["a.y"] == 6.0


def test_a_component_that_requests_model_exchange_runs_with_a_notice(gain_archive):
    element = gain("a").replace("<ssd:Component", '<ssd:Component implementation="ModelExchange"')
    result = amb_cosim.simulate(gain_archive(system("root", "", element)), isolated=False).dataset
    (notice,) = json.loads(result.attrs["notices"])
    assert_names(notice, "a", "model exchange", "co-simulation")


@pytest.mark.parametrize("unit", ["mm", "N"])
def test_the_unit_of_an_fmu_takes_precedence_with_a_notice(gain_archive, unit):
    ends = connector("u", "input") + connector("y", "output", unit)
    root = system("root", "", component("a", "resources/Metres.fmu", ends) + gain("b", "Metres"), connect("a.y", "b.u"))
    settings = {"a.u": 2.0, "a.k": 1.0, "b.k": 1.0}
    result = amb_cosim.simulate(gain_archive(root, units=("mm",)), set=settings, isolated=False).dataset
    (notice,) = json.loads(result.attrs["notices"])
    assert_names(notice, "a.y", unit, "in the FMU m")
    assert result["b.y"].values[-1] == result["a.y"].values[-1]


def test_a_value_of_an_unconnected_connector_is_a_notice(gain_archive):
    inner = system("n", connector("p", "parameter"), gain("a"))
    root = system("root", IN + OUT, inner, connect("In", "Out"), bind({"In": 2.0, "n.p": 3.0, "n.a.k": 4.0}))
    result = amb_cosim.simulate(gain_archive(root), isolated=False).dataset
    (notice,) = json.loads(result.attrs["notices"])
    assert_names(notice, "n.p", "not connected")
    assert "In" not in notice
    assert result["n.a.y"].values[-1] == 4.0


def kinds(name, u="input", y="output", k="parameter"):
    """A component whose connectors state these kinds; its FMU has an input u, an output y and a parameter k."""
    ends = connector("u", u) + connector("y", y) + connector("k", k)
    return component(name, "resources/Plain.fmu", ends)


FED_INPUT = system("n", connector("p", "input"), gain("a"), connect("a.y", "p"))
FEEDING_OUTPUT = system("n", connector("p", "output"), gain("a"), connect("p", "a.u"))


@pytest.mark.parametrize(
    ("elements", "links", "facts"),
    [
        (
            kinds("a", u="output", y="input") + kinds("b", u="output", y="input"),
            ["a.u b.y"],
            ("a.u", "output", "input"),
        ),
        (kinds("a", y="input"), ["In a.y"], ("a.y", "kind input", "causality output")),
        (kinds("a", u="output"), ["a.u Out"], ("a.u", "kind output", "causality input")),
        (kinds("a"), ["a.y In"], ("a.y (output)", "In (input)", "both")),
        (kinds("a"), ["Out a.u"], ("a.u (input)", "Out (output)", "neither")),
        (FED_INPUT + gain("b"), ["n.p b.u"], ("n.a.y (output)", "n.p (input)", "both")),
        (FEEDING_OUTPUT + gain("b"), ["b.y n.p"], ("n.a.u (input)", "n.p (output)", "neither")),
    ],
)
def test_a_connection_against_the_kinds_of_its_ends_is_refused(gain_archive, elements, links, facts):
    """One end supplies the value and the other takes it, in the archive and in the FMUs."""
    root = system("root", IN + OUT, elements, "".join(connect(*link.split()) for link in links))
    with raises_naming(ValueError, *facts):
        amb_cosim.simulate(gain_archive(root), isolated=False)


@pytest.mark.parametrize(
    ("element", "facts"),
    [
        (kinds("a", u="parameter"), ("a.u", "parameter", "in the FMU input")),
        (kinds("a", y="input"), ("a.y", "input", "in the FMU output")),
        (gain("a").replace("<ssc:Real/>", "<ssc:Integer/>", 1), ("a.u", "Integer", "in the FMU Real")),
    ],
)
def test_an_unconnected_contradiction_to_an_fmu_is_a_notice(gain_archive, element, facts):
    result = amb_cosim.simulate(gain_archive(system("root", "", element)), isolated=False).dataset
    (notice,) = json.loads(result.attrs["notices"])
    assert_names(notice, *facts)


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
def test_an_impossible_connection_is_refused_with_both_names(gain_archive, elements, links, bindings, facts):
    connections = "".join(connect(*link.split(maxsplit=2)) for link in links)
    with raises_naming(ValueError, *facts):
        amb_cosim.simulate(gain_archive(system("root", IN, elements, connections, bindings)), isolated=False)


def test_a_set_can_be_among_the_resources_of_an_fmu(last, gains, tmp_path):
    shutil.copy(gains["Plain"], tmp_path / "Own.fmu")
    with zipfile.ZipFile(tmp_path / "Own.fmu", "a") as own:
        own.writestr("resources/own.ssv", value_set({"k": 6.0}))
    root = system("root", "", gain("a", "Own", binding("", 'sourceBase="component" source="own.ssv"')))
    assert last(root, files={"resources/Own.fmu": (tmp_path / "Own.fmu").read_bytes()})["a.y"] == 6.0


def test_a_value_of_an_output_is_refused(gain_archive):
    with raises_naming(ValueError, "a.y", "an output"):
        amb_cosim.simulate(gain_archive(system("root", "", gain("a"), bindings=bind({"a.y": 1.0}))))


def test_variables_of_an_archive_are_plotted_over_time(gain_archive, runner, refuses, tmp_path):
    """The archive has no cycles; figures that need a rotor are refused."""
    path = gain_archive(system("root", "", INNER + gain("load"), connect("axle.Out", "load.u")))
    amb_cosim.simulate(path, isolated=False).save(tmp_path / "run")
    for variables in (["axle.motor.y"], ["motor.y", "load.*"]):
        assert runner("plot", "run", *variables, "-o", "y.png").exit_code == 0
    for command in (["plot", "run", "orbits"], ["compare", "run", "run"]):
        assert_names(refuses("system", *command), "scenario")


def test_a_connector_of_the_system_may_have_a_dot_in_its_name(gain_archive):
    """As those of buses have."""
    bus = connector("Bus.In", "input", "mm")
    link = '<ssd:Connection startConnector="Bus.In" endElement="a" endConnector="u"/>'
    path = gain_archive(
        system("root", bus, gain("a", "Metres"), link, bind({"Bus.In": 5.0, "a.k": 2.0})), units=("mm",)
    )
    for set, expected in ({}, 5.0), ({"Bus.In": "1 cm"}, 10.0):
        result = amb_cosim.simulate(path, set=set, isolated=False).dataset
        assert result["Bus.In"].values.tolist() == [expected] * 6
        assert result["Bus.In"].attrs["units"] == "mm"
        assert result["a.y"].values.tolist() == pytest.approx([0.002 * expected] * 6)


def test_a_connected_variable_may_have_a_wildcard_in_its_name(gains, gain_archive, tmp_path):
    """As tools without a naming convention write it; in a system file `?` and `*` connect what they match."""
    text = gain_archives.description().replace('name="y"', 'name="open?"').replace('name="u"', 'name="set*"')
    fmu = changed_archive(gains["Plain"], tmp_path / "Valve.fmu", {"modelDescription.xml": text})
    ends = connector("set*", "input") + connector("open?", "output")
    parts = "".join(component(name, "resources/Valve.fmu", ends) for name in "ab")
    root = system("root", "", parts, connect("a.open?", "b.set*"), bind({"a.k": 3.0, "b.k": 2.0}))
    result = amb_cosim.simulate(gain_archive(root, files={"resources/Valve.fmu": fmu.read_bytes()}), isolated=False)
    assert result.dataset["b.open?"].values[-1] == 6.0
