"""Archives that this package did not write: what is taken of them, and what is refused with a reason."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from gain_archives import NAMESPACES
from lxml.etree import fromstring

import amb_cosim
from amb_cosim.commands.cli import main
from amb_cosim.cosim.ssp import load_ssp
from amb_cosim.cosim.ssp.parameter_values import read_parameters
from amb_cosim.cosim.ssp.schema import PARAMETERS, parse
from amb_cosim.cosim.ssp.structure import TOOLS
from amb_cosim.cosim.system.experiment import Experiment
from tests.support.messages import assert_names, raises_naming

SUPPORT = Path(__file__).parents[1] / "cosim" / "support"
OMEGA = np.sqrt(2.0 * 400.0)  # of two masses of 1 kg against each other
BINDING = "<ssd:ParameterBinding {attributes}>{content}</ssd:ParameterBinding>"
BOUND = f"<ssd:ParameterBindings>{BINDING}</ssd:ParameterBindings>"
SET = """<ssv:ParameterSet {namespaces} version="1.0" name="set"><ssv:Parameters>{parameters}</ssv:Parameters>
</ssv:ParameterSet>"""
REAL = '<ssv:Parameter name="{name}"><ssv:Real value="{value}"/></ssv:Parameter>'


def parameter_set(**values):
    named = (REAL.format(name=name.replace("_dot_", "."), value=value) for name, value in values.items())
    return SET.format(namespaces=NAMESPACES, parameters="".join(named))


def component(name, source, connectors, binding="", attributes=""):
    listed = "".join(
        f'<ssd:Connector name="{variable}" kind="{kind}"><ssc:Real/></ssd:Connector>' for variable, kind in connectors
    )
    return (
        f'<ssd:Component name="{name}" source="{source}" {attributes}><ssd:Connectors>{listed}</ssd:Connectors>'
        f"{binding}</ssd:Component>"
    )


LEFT = BOUND.format(attributes='source="resources/left.ssv"', content="")
MASS = [("force", "input"), ("push", "input"), ("x", "output")]
SPRING = [("left", "input"), ("right", "input"), ("on_left", "output"), ("on_right", "output")]
LINKS = [
    ("left", "x", "spring", "left"),
    ("spring", "right", "right", "x"),  # the end first: SSP does not say which comes first
    ("spring", "on_left", "left", "force"),
    ("spring", "on_right", "right", "force"),
]
PUSH = '<ssd:Connection startConnector="push" endElement="{0}" endConnector="push"/>'


def structure(
    elements=None,
    extra_link="",
    experiment='<ssd:DefaultExperiment startTime="0" stopTime="0.5"/>',
    system_binding="",
):
    parts = elements or [
        component("spring", "resources/Spring.fmu", SPRING),
        component("left", "resources/Mass.fmu", MASS, LEFT),
        component("right", "resources/Mass.fmu", MASS),
    ]
    links = "".join(
        f'<ssd:Connection startElement="{a}" startConnector="{b}" endElement="{c}" endConnector="{d}"/>'
        for a, b, c, d in LINKS
    )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><ssd:SystemStructureDescription {NAMESPACES} version="1.0" name="two">'
        '<ssd:System name="two" description="two masses"><ssd:Connectors><ssd:Connector name="push" kind="input">'
        f"<ssc:Real/></ssd:Connector></ssd:Connectors>{system_binding}<ssd:Elements>{''.join(parts)}</ssd:Elements>"
        f"<ssd:Connections>{links}{PUSH.format('left')}{PUSH.format('right')}{extra_link}</ssd:Connections>"
        f"</ssd:System>{experiment}</ssd:SystemStructureDescription>"
    )


@pytest.fixture(scope="module")
def fmus(create_once):
    from pythonfmu.builder import FmuBuilder

    def fill(folder):
        for script in ("mass.py", "spring.py"):
            FmuBuilder.build_FMU(SUPPORT / script, dest=folder)

    return create_once("masses", fill)


@pytest.fixture
def archive(fmus, tmp_path):
    """`archive(text, **files)`: an archive with the FMUs, a structure and parameter sets."""

    def write(text, sets=None):
        path = tmp_path / "two.ssp"
        with zipfile.ZipFile(path, "w") as content:
            content.writestr("SystemStructure.ssd", text)
            for name in ("Mass.fmu", "Spring.fmu"):
                content.write(fmus / name, f"resources/{name}")
            for name, document in (sets or {"left.ssv": parameter_set(start=0.01)}).items():
                content.writestr(f"resources/{name}", document)
        return path

    return write


STEP = 1e-3


def test_connections_parameters_and_signals_are_those_of_the_document(archive):
    bound = BOUND.format(
        attributes='prefix="spr"',
        content=f"<ssd:ParameterValues>{parameter_set(ing_dot_k=300.0, ing_dot_unknown=1.0)}</ssd:ParameterValues>",
    )
    system, experiment = load_ssp(archive(structure(system_binding=bound)), STEP)
    assert [c.name for c in system.components] == ["spring", "left", "right"]
    assert {(link.source, link.target) for link in system.connections} == {
        ("left.x", "spring.left"),
        ("right.x", "spring.right"),
        ("spring.on_left", "left.force"),
        ("spring.on_right", "right.force"),
    }
    assert system.signal("push").targets == ("left.push", "right.push")
    assert system.parameters == {"spring": {"k": 300.0}, "left": {"start": 0.01}, "right": {}}
    assert (experiment.stop_time, experiment.inputs) == (0.5, {})


def test_a_value_of_what_no_fmu_has_is_a_notice(archive):
    values = parameter_set(spring_dot_k=400.0, spring_dot_kk=1.0, sprng_dot_k=1.0)
    bound = BOUND.format(attributes="", content=f"<ssd:ParameterValues>{values}</ssd:ParameterValues>")
    result = amb_cosim.simulate(archive(structure(system_binding=bound)), step_size=1e-3).dataset
    unknown, unused = json.loads(result.attrs["notices"])
    assert_names(unknown, "sprng.k")
    assert_names(unused, "spring", "Spring.fmu", "kk")


def test_a_foreign_archive_runs(archive):
    values = f"<ssd:ParameterValues>{parameter_set(spring_dot_k=400.0)}</ssd:ParameterValues>"
    path = archive(structure(system_binding=BOUND.format(attributes="", content=values)))
    result = amb_cosim.simulate(path, step_size=1e-3).dataset
    left, right, time = (result[name].values for name in ("left.x", "right.x", "time"))
    growth = np.exp(0.25 * OMEGA**2 * STEP * 0.5)  # of the held force
    np.testing.assert_allclose(left, 0.005 + 0.005 * np.cos(OMEGA * time), atol=0.005 * (growth - 1.0) * 1.2)
    np.testing.assert_allclose(left + right, 0.01, atol=1e-12)


def transformed(text, ends, law):
    """The structure with a linear transformation of the connection to these ends."""
    before = 'endElement="{}" endConnector="{}"'.format(*ends)
    assert text.count(f"{before}/>") == 1
    return text.replace(f"{before}/>", f"{before}><ssc:LinearTransformation {law}/></ssd:Connection>")


def test_factor_and_offset_of_a_connection_act_on_what_it_carries(archive):
    """Half the stiffness with twice the forces is the same to the last bit; an offset is the spring's length."""

    def run(k, force, length):
        values = f"<ssd:ParameterValues>{parameter_set(spring_dot_k=k)}</ssd:ParameterValues>"
        text = structure(system_binding=BOUND.format(attributes="", content=values))
        for mass in ("left", "right"):
            text = transformed(text, (mass, "force"), f'factor="{force}"')
        return amb_cosim.simulate(archive(transformed(text, ("spring", "left"), f'offset="{length}"')), step_size=STEP)

    plain, doubled, long = run(400.0, 1.0, 0.0), run(200.0, 2.0, 0.0), run(400.0, 1.0, 0.02)
    assert plain.dataset["left.x"].values.tolist() == doubled.dataset["left.x"].values.tolist()
    time, distance = long.dataset["time"].values, (long.dataset["right.x"] - long.dataset["left.x"]).values
    growth = np.exp(0.25 * OMEGA**2 * STEP * 0.5)
    np.testing.assert_allclose(distance, 0.02 - 0.03 * np.cos(OMEGA * time), atol=0.03 * (growth - 1.0) * 1.2)


def test_first_values_of_inputs_are_bound_too(archive):
    sets = {"left.ssv": parameter_set(start=0.01, push=2.0, force=9.0)}
    _, experiment = load_ssp(archive(structure(), sets), STEP)
    assert experiment.inputs == {"left.push": 2.0}, "a connected input has no first value of its own"


def test_another_experiment_keeps_the_first_values_of_the_archive(archive):
    path = archive(structure(), {"left.ssv": parameter_set(start=0.01, push=2.0, force=9.0)})
    for inputs, push in (({}, 2.0), ({"left.push": 3.0}, 3.0)):
        result = amb_cosim.simulate(path, Experiment(STEP, 2 * STEP, inputs=inputs), step_size=STEP).dataset
        assert json.loads(result.attrs["initial_inputs"])["push"] == push


def test_units_go_with_the_value():
    text = SET.format(
        namespaces=NAMESPACES,
        parameters='<ssv:Parameter name="gap"><ssv:Real value="0.6" unit="mm"/></ssv:Parameter>'
        '<ssv:Parameter name="law"><ssv:Enumeration value="newton"/></ssv:Parameter>'
        '<ssv:Parameter name="n"><ssv:Integer value="3"/></ssv:Parameter>'
        '<ssv:Parameter name="on"><ssv:Boolean value="false"/></ssv:Parameter>',
    )
    root = parse(text.encode(), PARAMETERS, "set")
    assert read_parameters(root, "set") == {"gap": [("0.6", "mm")], "law": ["newton"], "n": [3], "on": [False]}


def test_a_value_of_another_type_is_refused():
    parameters = '<ssv:Parameter name="n"><ssv:Integer value=" 3x"/></ssv:Parameter>'
    root = fromstring(SET.format(namespaces=NAMESPACES, parameters=parameters).encode())
    with raises_naming(ValueError, "n", "' 3x'", "Integer", "Real, Float64"):
        read_parameters(root, "set")


MAPPED = BOUND.format(
    attributes='source="resources/left.ssv"', content='<ssd:ParameterMapping source="resources/none.ssm"/>'
)
IN_FMU = BOUND.format(attributes='source="resources/left.ssv" sourceBase="component"', content="")
TO_RIGHT = 'endElement="right" endConnector="push">'
SWITCHED = f"""<ssd:Connection startElement="left" startConnector="x" {TO_RIGHT}
<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/></ssc:BooleanMappingTransformation>
</ssd:Connection>"""
INNER = '<ssd:System name="inner"/>'


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("<ssd", ("SystemStructure.ssd", "XML")),
        (structure().replace('version="1.0" name="two"', 'version="1.0"'), ("SSP 1.0", "line 1", "'name'")),
        (structure([INNER]), ("a connection", "'left'", "inner")),
        (structure([component("a.b", "resources/Mass.fmu", MASS)]), ("a.b", "dot")),
        (structure([component("left", "../Mass.fmu", MASS)]), ("'../Mass.fmu'",)),
        (structure([component("left", "http://host/Mass.fmu", MASS)]), ("relative paths",)),
        (structure(experiment=""), ("stop time", "--until")),
        (structure(system_binding=MAPPED), ("'resources/none.ssm'",)),
        (structure(system_binding=IN_FMU), ("'resources/left.ssv'", "in an FMU")),
        (structure(extra_link=SWITCHED), ("left.x", "transforms")),
    ],
)
def test_what_is_not_taken_is_refused_with_its_reason(archive, text, facts):
    with raises_naming(ValueError, *facts):
        load_ssp(archive(text), STEP)


@pytest.mark.parametrize(
    "harmless",
    ['<ssc:LinearTransformation factor="1" offset="0.0"/>', '<ssd:ConnectionGeometry pointsX="0" pointsY="1"/>'],
)
def test_what_leaves_a_connection_as_it_is_is_taken(archive, harmless):
    text = structure().replace('endElement="right" endConnector="push"/>', f"{TO_RIGHT}{harmless}</ssd:Connection>")
    assert harmless in text
    assert load_ssp(archive(text), STEP)[0].signal("push").targets == ("left.push", "right.push")


def annotated(content):
    """The structure with an annotation of its system."""
    names = " ".join(f'xmlns:{prefix}="{name}"' for prefix, name in TOOLS.items())
    note = f'<ssc:Annotation {names} type="test">{content}</ssc:Annotation>'
    return structure().replace("</ssd:System>", f"<ssd:Annotations>{note}</ssd:Annotations></ssd:System>")


@pytest.mark.parametrize(
    ("content", "coupling"),
    [
        ('<osp:Algorithm><osp:FixedStepAlgorithm baseStepSize="2e-3"/></osp:Algorithm>', "jacobi"),
        (
            '<oms:SimulationInformation><oms:FixedStepMaster stepSize="2e-3"/></oms:SimulationInformation>',
            "gauss_seidel",
        ),
        ('<amb:Master stepSize="2e-3" coupling="jacobi"/>', "jacobi"),
    ],
)
def test_the_step_of_an_annotation_is_taken(archive, content, coupling):
    path = archive(annotated(content))
    assert load_ssp(path)[1].step_size == 2e-3
    assert load_ssp(path)[0].coupling == coupling
    assert load_ssp(path, STEP)[1].step_size == STEP


def test_an_order_that_is_not_known_is_refused(archive):
    with raises_naming(ValueError, "coupling", "backwards", "jacobi"):
        load_ssp(archive(annotated('<amb:Master stepSize="2e-3" coupling="backwards"/>')))


@pytest.mark.parametrize("start", [20.0, 0.0004, -0.1])
def test_a_run_of_an_archive_begins_and_is_recorded_at_its_start_time(archive, start):
    text = structure(experiment=f'<ssd:DefaultExperiment startTime="{start!r}" stopTime="{start + 0.005!r}"/>')
    time = amb_cosim.simulate(archive(text), step_size=STEP).dataset["time"].values
    assert time[[0, -1]] == pytest.approx([start, start + 0.005], abs=1e-12)


DECLARED = '<!DOCTYPE ssd [<!ENTITY side "left"><!ENTITY file SYSTEM "file:///etc/hostname">{0}]>'
EXPANDING = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 20}">' for k in range(1, 9))


def declaring(text, more=""):
    """The document with entities declared."""
    end = text.index("?>") + 2 if text.startswith("<?xml") else 0
    return text[:end] + DECLARED.format(more) + text[end:]


def test_an_entity_stands_for_its_text_in_an_archive(archive):
    system, _ = load_ssp(archive(declaring(structure().replace('name="left"', 'name="&side;"'))), STEP)
    assert "left" in [component.name for component in system.components]


@pytest.mark.parametrize(("more", "name"), [("", "&file;"), (f'<!ENTITY e0 "aaaaaaaaaa">{EXPANDING}', "&e8;")])
def test_an_entity_of_a_file_or_of_great_length_is_refused(archive, more, name):
    text = declaring(structure().replace('description="', f'description="{name}'), more)
    assert name in text
    with raises_naming(ValueError, "SystemStructure.ssd", "XML"):
        load_ssp(archive(text), STEP)


def test_a_step_must_be_known(archive):
    with raises_naming(ValueError, "communication step", "--step"):
        load_ssp(archive(structure()))


def test_what_is_no_archive_is_refused(tmp_path):
    (tmp_path / "text.ssp").write_text("no archive", encoding="utf-8")
    with raises_naming(ValueError, "zip archive"):
        load_ssp(tmp_path / "text.ssp")
    with raises_naming(ValueError, "no archive", "none.ssp"):
        load_ssp(tmp_path / "none.ssp")


def test_the_command_refuses_what_an_archive_has_no_use_for(archive):
    path = archive(structure())
    for options, message in (
        (["--rotor", "compressor"], "--rotor cannot be used with an SSP archive"),
        ([], "defines no communication step"),
        (["--step", "1 kg"], "--step = '1 kg' has unit kg"),
    ):
        refused = CliRunner().invoke(main, ["run", str(path), *options])
        assert refused.exit_code == 2
        assert message in refused.output


@pytest.mark.parametrize("command", ["run", "simulate"])
def test_the_advised_options_let_an_archive_run(archive, command, tmp_path):
    arguments = [command, str(archive(structure(experiment=""))), "-o", str(tmp_path / "out")]
    for option, value in (("--step", "1ms"), ("--until", "10 ms")):
        refused = CliRunner().invoke(main, arguments)
        assert refused.exit_code == 2
        assert option in refused.output
        arguments += [option, value]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    assert "completed at t = 0.01 s" in done.output


def test_a_system_file_has_its_times_in_its_experiment(tmp_path):
    (tmp_path / "any.toml").write_text("", encoding="utf-8")
    refused = CliRunner().invoke(main, ["simulate", str(tmp_path / "any.toml"), "--until", "1 s"])
    assert refused.exit_code == 2
    assert_names(refused.output, "--until", "experiment")
