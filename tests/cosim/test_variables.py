"""Variables of other tools' FMUs: texts, bytes, Booleans and Enumerations are set; names have no meaning of ours."""

import json
import zipfile
from pathlib import Path

import pytest
from fmu_systems import write_system

import amb_cosim
from amb_cosim.commands.options import parse_settings
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.cosim.system.system_file import load_experiment, load_system
from tests.ssp.gain_archives import bind, component, structure, system
from tests.support.messages import raises_naming

SOURCE = Path(__file__).parent / "support" / "texts.c"
UNITS = '<Unit name="s"><BaseUnit s="1"/></Unit><Unit name="ms"><BaseUnit s="1" factor="0.001"/></Unit>'
ITEMS = '<Item name="slow" value="1"/><Item name="fast" value="3"/>'
DESCRIPTIONS = {
    2: f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Texts" guid="{{texts}}">
<CoSimulation modelIdentifier="texts" canHandleVariableCommunicationStepSize="true"/>
<TypeDefinitions><SimpleType name="Speed"><Enumeration>{ITEMS}</Enumeration></SimpleType></TypeDefinitions>
<ModelVariables>
<ScalarVariable name="file" valueReference="0" causality="parameter" variability="fixed"><String start="none"/>
</ScalarVariable>
<ScalarVariable name="flag" valueReference="1" causality="parameter" variability="fixed"><Boolean start="false"/>
</ScalarVariable>
<ScalarVariable name="choice" valueReference="2" causality="parameter" variability="fixed">
<Enumeration declaredType="Speed" start="1"/></ScalarVariable>
<ScalarVariable name="y" valueReference="4" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="fault_code" valueReference="5" causality="output" variability="discrete"><Integer/>
</ScalarVariable>
<ScalarVariable name="said" valueReference="6" causality="output" variability="discrete"><String/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="4"/><Unknown index="5"/><Unknown index="6"/></Outputs></ModelStructure>
</fmiModelDescription>
""",
    3: f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Texts" instantiationToken="{{texts}}">
<CoSimulation modelIdentifier="texts" canHandleVariableCommunicationStepSize="true"/>
<TypeDefinitions><EnumerationType name="Speed">{ITEMS}</EnumerationType></TypeDefinitions>
<ModelVariables>
<Float64 name="time" valueReference="9" causality="independent" variability="continuous"/>
<String name="file" valueReference="0" causality="parameter" variability="fixed"><Start value="none"/></String>
<Boolean name="flag" valueReference="1" causality="parameter" variability="fixed" start="false"/>
<Enumeration name="choice" valueReference="2" causality="parameter" variability="fixed" declaredType="Speed" start="1"/>
<Binary name="blob" valueReference="3" causality="parameter" variability="fixed"><Start value="00"/></Binary>
<String name="lines" valueReference="7" causality="parameter" variability="fixed"><Dimension start="2"/>
<Start value="a"/><Start value="b"/></String>
<Float64 name="y" valueReference="4" causality="output"/>
<Int32 name="fault_code" valueReference="5" causality="output" variability="discrete"/>
<String name="said" valueReference="6" causality="output" variability="discrete"/>
</ModelVariables>
<ModelStructure><Output valueReference="4"/><Output valueReference="5"/><Output valueReference="6"/></ModelStructure>
</fmiModelDescription>
""",
}


@pytest.fixture
def run(fmu_from_c, tmp_path):
    """`run(version, parameters="", **options)`: data of the FMU alone; `choice` names its Enumeration."""

    def simulate(version, parameters="", more="", choice="choice", **options):
        description = DESCRIPTIONS[version].replace('name="choice"', f'name="{choice}"')
        fmu = fmu_from_c(SOURCE, description, version, f"texts with {choice}")
        path = write_system(tmp_path, {"one": fmu}, more=f"{more}[parameters.one]\n{parameters}")
        return amb_cosim.simulate(path, isolated=False, **options).dataset

    return simulate


@pytest.mark.parametrize("version", [2, 3])
def test_string_boolean_and_enumeration_parameters_are_set(run, version):
    result = run(version, 'file = "table.csv"\nflag = true\nchoice = "fast"')
    assert result["one.y"].values.tolist() == [len("table.csv") + 100 + 3000] * 11
    assert json.loads(result.attrs["parameters"])["one"]["file"] == "table.csv"
    plain = run(version)
    assert plain["one.y"].values[-1] == len("none") + 1000
    assert set(plain["one.fault_code"].values) == {1}, "which is a fault in FMUs of this project alone"


@pytest.mark.parametrize("version", [2, 3])
def test_a_text_is_passed_on_unchanged(run, version):
    """Blanks, digits, wildcards and letters that take two bytes in UTF-8."""
    for text in ("", " a ", "3", "true", "*", "[red]", "Lüfter"):
        assert run(version, set={"one.file": text})["one.y"].values[-1] == len(text.encode()) + 1000


@pytest.mark.parametrize(
    ("setting", "y"),
    [
        ("one.file=a=fast", len("none") + 3000),
        ("one.file=a = 3", len("none") + 3000),
        ("one.file=*=fast", len("none") + 3000),
        ("one.file=b=c", len("b=c") + 1000),
        ("one.file = b = c ", len("b = c") + 1000),
        ("one.file=ab==", len("ab==") + 1000),
        ("one.file=table.csv", len("table.csv") + 1000),
    ],
)
def test_names_and_texts_may_have_equals_signs(run, setting, y):
    """The longest name that exists counts: `file=a` is an Enumeration, `file` a String."""
    assert run(2, choice="file=a", set=parse_settings([setting]))["one.y"].values[-1] == y


def test_a_binary_parameter_is_written_in_hexadecimal_digits(run):
    result = run(3, 'blob = "01 ff"')
    assert result["one.y"].values[-1] == 4 + 1000 + 10000 * 256
    assert json.loads(result.attrs["parameters"])["one"]["blob"] == "01ff"


CONNECTED = '[[connect]]\nfrom = "one"\nto = "one"\nvariables = { "y" = "file" }\n'
CHANGED = '[[experiment.event]]\ntime = "5 ms"\nset = { "one.file" = "b" }\n'
AS_INPUT = '[experiment.inputs]\n"one.file" = "b"\n'


@pytest.mark.parametrize(
    ("version", "options", "facts"),
    [
        (2, {"set": {"one.file": 3}}, ("one.file", "3", "String", "text")),
        (2, {"set": {"one.file": "a\0b"}}, ("one.file", "String", "code 0")),
        (3, {"set": {"one.blob": "0g"}}, ("one.blob", "'0g'", "hexadecimal")),
        (3, {"set": {"one.lines": "a"}}, ("one.lines", "array", "String")),
        (2, {"set": {"one.flag": "maybe"}}, ("one.flag", "maybe", "true or false")),
        (2, {"set": {"one.choice": "backwards"}}, ("one.choice", "backwards", "1 (slow)")),
        (2, {"set": {"one.fil": "a"}}, ("one", "'fil'", "file")),
        *(
            (2, {"choice": "file=a", "set": parse_settings([setting])}, ("one", "file=a"))
            for setting in ("one.fill=a=fast", "one.fil=b")
        ),
        (2, {"more": CONNECTED}, ("one.file", "String", "connected")),
        (2, {"more": CHANGED}, ("one.file", "String", "changed")),
        (2, {"more": AS_INPUT}, ("one.file", "a parameter", "input")),
    ],
)
def test_a_wrong_value_of_a_text_or_choice_is_refused(run, version, options, facts):
    with raises_naming(ValueError, *facts):
        run(version, **options)


@pytest.mark.parametrize(
    ("declared", "is_rate"),
    [
        ('<Real start="2e-3" unit="s"/>', True),
        ('<Real start="2e-3"/>', True),
        ('<Real start="2" unit="ms"/>', False),
        ('<Real start="-1"/>', False),
        ('<Integer start="2"/>', False),
    ],
)
def test_a_sample_time_not_in_seconds_sets_no_rate(fmu_from_c, tmp_path, declared, is_rate):
    """The FMU accepts only steps of its rate, if it has one: every second step of 1 ms."""
    text = DESCRIPTIONS[2].replace(' canHandleVariableCommunicationStepSize="true"', "")
    text = text.replace("<TypeDefinitions>", f"<UnitDefinitions>{UNITS}</UnitDefinitions><TypeDefinitions>")
    parameter = '<ScalarVariable name="sample_time" valueReference="8" causality="parameter" variability="fixed">'
    text = text.replace("</ModelVariables>", f"{parameter}{declared}</ScalarVariable></ModelVariables>")
    fmu = fmu_from_c(SOURCE, text, name=f"rate-{sum(declared.encode())}")
    path = write_system(tmp_path, {"one": fmu})
    plan = experiment_plan(load_experiment(path), assemble(load_system(path)))
    assert plan.system.component("one").every == (2 if is_rate else 1)


def test_a_name_with_brackets_is_a_variable_and_no_pattern(fmu_from_c, tmp_path):
    """As Modelica names elements of arrays over enumerations; brackets are wildcards elsewhere."""
    text = DESCRIPTIONS[2].replace('name="flag"', 'name="flag[State.on]"')
    fmu = fmu_from_c(SOURCE, text, name="bracketed")
    path = write_system(tmp_path, {"one": fmu})
    data = amb_cosim.simulate(path, set={"one.flag[State.on]": True}, isolated=False).dataset
    assert data["one.y"].values[-1] == len("none") + 100 + 1000


def test_strings_and_bytes_of_an_archive_are_set(fmu_from_c, tmp_path):
    fmu = fmu_from_c(SOURCE, DESCRIPTIONS[3], 3)
    kinds = {"file": 'String value=" a b "', "blob": 'Binary value="0102"', "flag": 'Boolean value="true"'}
    kinds["choice"] = 'Enumeration value="fast"'
    values = {f"one.{name}": f"<ssv:{kind}/>" for name, kind in kinds.items()}
    root = system("root", "", component("one", "Texts.fmu", ""), bindings=bind(values))
    text = structure(root, experiment='<ssd:DefaultExperiment stopTime="0.01"/>')
    with zipfile.ZipFile(tmp_path / "texts.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", text)
        archive.write(fmu, "Texts.fmu")
    result = amb_cosim.simulate(tmp_path / "texts.ssp", step_size=1e-3, isolated=False).dataset
    assert result["one.y"].values[-1] == len(" a b ") + 100 + 3000 + 30000
