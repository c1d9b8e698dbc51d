"""Archives of other tools: supported content, and content refused with a reason."""

import json
import zipfile

import gain_archives
import numpy as np
import pytest
from gain_archives import bind, binding, component, connect, connector, system, value_set
from lxml.etree import fromstring

import amb_cosim
from amb_cosim.cosim.ssp import load_ssp
from amb_cosim.cosim.ssp.parameter_values import read_parameters
from amb_cosim.cosim.ssp.schema import PARAMETERS, parse
from amb_cosim.cosim.ssp.structure import TOOLS
from amb_cosim.cosim.system.experiment import Experiment
from tests.support.messages import assert_names, raises_naming

OMEGA = np.sqrt(2.0 * 400.0)  # of two masses of 1 kg against each other
LEFT = binding("", 'source="resources/left.ssv"')
MASS = connector("force", "input") + connector("push", "input") + connector("x", "output")
SPRING_FMU = "resources/Spring.fmu"
SPRING = connector("left", "input") + connector("right", "input")
SPRING += connector("on_left", "output") + connector("on_right", "output")
LINKS = (
    *("left.x spring.left", "spring.right right.x"),  # the end first: SSP does not say which comes first
    *("spring.on_left left.force", "spring.on_right right.force", "push left.push", "push right.push"),
)


def mass(name, source="resources/Mass.fmu", bindings=""):
    return component(name, source, MASS, bindings)


def structure(elements="", extra_link="", experiment=gain_archives.EXPERIMENT, bindings=""):
    """Two masses and a spring, or other elements."""
    parts = elements or mass("left", bindings=LEFT) + mass("right") + component("spring", SPRING_FMU, SPRING)
    links = "".join(connect(*link.split()) for link in LINKS) + extra_link
    root = system("two", connector("push", "input"), parts, links, bindings)
    return gain_archives.structure(root, experiment=experiment)


@pytest.fixture
def archive(foreign_fmus, tmp_path):
    """`archive(text, **files)`: an archive with the FMUs, a structure and parameter sets."""

    def write(text, sets=None):
        path = tmp_path / "two.ssp"
        with zipfile.ZipFile(path, "w") as content:
            content.writestr("SystemStructure.ssd", text)
            for name in ("Mass.fmu", "Spring.fmu"):
                content.write(foreign_fmus / name, f"resources/{name}")
            for name, document in (sets or {"left.ssv": value_set({"start": 0.01})}).items():
                content.writestr(f"resources/{name}", document)
        return path

    return write


STEP = 1e-3


def simulated(path, *experiment):
    return amb_cosim.simulate(path, *experiment, step_size=STEP, isolated=False).dataset


def test_connections_parameters_and_signals_match_the_document(archive):
    bound = bind({"ing.k": 300.0, "ing.unknown": 1.0}, attributes='prefix="spr"')
    two, experiment = load_ssp(archive(structure(bindings=bound)), STEP)
    assert [c.name for c in two.components] == ["left", "right", "spring"]
    assert {(link.source, link.target) for link in two.connections} == {
        ("left.x", "spring.left"),
        ("right.x", "spring.right"),
        ("spring.on_left", "left.force"),
        ("spring.on_right", "right.force"),
    }
    assert two.signal("push").targets == ("left.push", "right.push")
    assert two.parameters == {"spring": {"k": 300.0}, "left": {"start": 0.01}, "right": {}}
    assert (experiment.stop_time, experiment.inputs) == (0.5, {})


def test_a_value_of_an_unknown_variable_is_a_notice(archive):
    bound = bind({"spring.k": 400.0, "spring.kk": 1.0, "sprng.k": 1.0})
    result = simulated(archive(structure(bindings=bound)))
    unknown, unused = json.loads(result.attrs["notices"])
    assert_names(unknown, "sprng.k")
    assert_names(unused, "spring", "Spring.fmu", "kk")


def test_a_foreign_archive_runs(archive):
    result = simulated(archive(structure(bindings=bind({"spring.k": 400.0}))))
    left, right, time = (result[name].values for name in ("left.x", "right.x", "time"))
    growth = np.exp(0.25 * OMEGA**2 * STEP * 0.5)  # of the held force
    np.testing.assert_allclose(left, 0.005 + 0.005 * np.cos(OMEGA * time), atol=0.005 * (growth - 1.0) * 1.2)
    np.testing.assert_allclose(left + right, 0.01, atol=1e-12)


def test_a_changed_experiment_keeps_the_initial_values_of_the_archive(archive):
    """A connected input, such as the force, has no initial value."""
    path = archive(structure(), {"left.ssv": value_set({"start": 0.01, "push": 2.0, "force": 9.0})})
    assert load_ssp(path, STEP)[1].inputs == {"left.push": 2.0}
    for inputs, push in (({}, 2.0), ({"left.push": 3.0}, 3.0)):
        result = simulated(path, Experiment(STEP, 2 * STEP, inputs=inputs))
        assert json.loads(result.attrs["initial_inputs"])["push"] == push


def test_values_carry_their_units():
    values = {
        "gap": '<ssv:Real value="0.6" unit="mm"/>',
        "law": '<ssv:Enumeration value="newton"/>',
        "n": '<ssv:Integer value="3"/>',
        "on": '<ssv:Boolean value="false"/>',
    }
    root = parse(value_set(values).encode(), PARAMETERS, "set")
    assert read_parameters(root, "set") == {"gap": [("0.6", "mm")], "law": ["newton"], "n": [3], "on": [False]}


def test_a_value_of_another_type_is_refused():
    root = fromstring(value_set({"n": '<ssv:Integer value=" 3x"/>'}).encode())
    with raises_naming(ValueError, "n", "' 3x'", "Integer", "Real, Float64"):
        read_parameters(root, "set")


MAPPED = binding('<ssd:ParameterMapping source="resources/none.ssm"/>', 'source="resources/left.ssv"')
IN_FMU = binding("", 'source="resources/left.ssv" sourceBase="component"')
TABLE = '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>'
SWITCHED = connect("left.x", "right.push", f"{TABLE}</ssc:BooleanMappingTransformation>")


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("<ssd", ("SystemStructure.ssd", "XML")),
        (structure().replace('version="1.0" name="gains"', 'version="1.0"'), ("SSP 1.0", "line 1", "'name'")),
        (structure('<ssd:System name="inner"/>'), ("a connection", "'left'", "inner")),
        (structure(mass("a.b")), ("a.b", "dot")),
        (structure(mass("left", "../Mass.fmu")), ("'../Mass.fmu'",)),
        (structure(mass("left", "http://host/Mass.fmu")), ("relative paths",)),
        (structure(experiment=""), ("stop time", "--until")),
        (structure(bindings=MAPPED), ("'resources/none.ssm'",)),
        (structure(bindings=IN_FMU), ("'resources/left.ssv'", "in an FMU")),
        (structure(extra_link=SWITCHED), ("left.x", "transforms")),
    ],
)
def test_unsupported_content_is_refused_with_the_reason(archive, text, facts):
    with raises_naming(ValueError, *facts):
        load_ssp(archive(text), STEP)


@pytest.mark.parametrize(
    "harmless",
    ['<ssc:LinearTransformation factor="1" offset="0.0"/>', '<ssd:ConnectionGeometry pointsX="0" pointsY="1"/>'],
)
def test_attributes_without_effect_on_a_connection_are_accepted(archive, harmless):
    link = "push", "right.push"
    text = structure().replace(connect(*link), connect(*link, harmless))
    assert harmless in text
    assert load_ssp(archive(text), STEP)[0].signal("push").targets == ("left.push", "right.push")


SWAPPED = {"left": "right", "right": "left"}


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
def test_the_step_of_an_annotation_is_used(archive, content, coupling):
    path = archive(annotated(content))
    assert load_ssp(path)[1].step_size == 2e-3
    assert load_ssp(path)[0].coupling == coupling
    assert load_ssp(path, STEP)[1].step_size == STEP


def test_components_step_in_the_order_of_the_annotation(archive):
    steps = "".join(f'<amb:Step component="{name}" every="1"/>' for name in ("right", "absent", "left"))
    text = annotated(f'<amb:Master stepSize="2e-3" coupling="gauss_seidel">{steps}</amb:Master>')
    names, plain = ([c.name for c in load_ssp(archive(t), STEP)[0].components] for t in (text, structure()))
    assert (plain.index("left") < plain.index("right"), names) == (True, [SWAPPED.get(name, name) for name in plain])


def test_an_unknown_stepping_order_is_refused(archive):
    with raises_naming(ValueError, "coupling", "backwards", "jacobi"):
        load_ssp(archive(annotated('<amb:Master stepSize="2e-3" coupling="backwards"/>')))


@pytest.mark.parametrize("start", [20.0, 0.0004, -0.1])
def test_a_run_of_an_archive_begins_and_is_recorded_at_its_start_time(archive, start):
    text = structure(experiment=f'<ssd:DefaultExperiment startTime="{start!r}" stopTime="{start + 0.005!r}"/>')
    time = simulated(archive(text))["time"].values
    assert time[[0, -1]] == pytest.approx([start, start + 0.005], abs=1e-12)


DECLARED = '<!DOCTYPE ssd [<!ENTITY side "left"><!ENTITY file SYSTEM "file:///etc/hostname">{0}]>'
EXPANDING = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 20}">' for k in range(1, 9))


def declaring(text, more=""):
    """The document with entities declared."""
    end = text.index("?>") + 2 if text.startswith("<?xml") else 0
    return text[:end] + DECLARED.format(more) + text[end:]


def test_an_internal_entity_is_expanded(archive):
    system, _ = load_ssp(archive(declaring(structure().replace('name="left"', 'name="&side;"'))), STEP)
    assert "left" in [component.name for component in system.components]


@pytest.mark.parametrize(("more", "name"), [("", "&file;"), (f'<!ENTITY e0 "aaaaaaaaaa">{EXPANDING}', "&e8;")])
def test_an_entity_of_a_file_or_of_great_length_is_refused(archive, more, name):
    text = declaring(structure().replace('name="two"', f'name="two" description="{name}"'), more)
    assert name in text
    with raises_naming(ValueError, "SystemStructure.ssd", "XML"):
        load_ssp(archive(text), STEP)


def test_a_file_that_is_no_archive_is_refused(tmp_path):
    (tmp_path / "text.ssp").write_text("no archive", encoding="utf-8")
    with raises_naming(ValueError, "zip archive"):
        load_ssp(tmp_path / "text.ssp")
    with raises_naming(ValueError, "no archive", "none.ssp"):
        load_ssp(tmp_path / "none.ssp")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--rotor", "compressor"], "--rotor cannot be used with an SSP archive"),
        ([], "defines no communication step"),
        (["--step", "1 kg"], "--step = '1 kg' has unit kg"),
    ],
)
def test_the_command_refuses_options_without_effect_on_an_archive(archive, refuses, options, message):
    refuses(message, "run", str(archive(structure())), *options)


@pytest.mark.parametrize("command", ["run", "simulate"])
def test_the_advised_options_let_an_archive_run(archive, refuses, runner, command):
    arguments = [command, str(archive(structure(experiment=""))), "-o", "out"]
    for option, value in (("--step", "1ms"), ("--until", "10 ms")):
        refuses(option, *arguments)
        arguments += [option, value]
    done = runner(*arguments)
    assert done.exit_code == 0, done.output
    assert "completed at t = 0.01 s" in done.output


def test_a_system_file_has_its_times_in_its_experiment(refuses, tmp_path):
    (tmp_path / "any.toml").write_text("", encoding="utf-8")
    assert_names(refuses("--until", "simulate", "any.toml", "--until", "1 s"), "experiment")
