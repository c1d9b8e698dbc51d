"""Archives of SSP 2.0: arrays are connected and bound whole or element by element, in every number type of FMI 3.0."""

import json
import zipfile

import pytest
import xarray as xr
from fmu_systems import write_system

import amb_cosim
from tests.ssp import gain_archives
from tests.support.messages import assert_names, raises_naming

TYPES = ("Float64", "Int8", "UInt64")
PAIR = '<ssc:Dimension size="2"/>'
NOTE = '<ssc:MetaData kind="general" type="text/plain"><ssc:Content>of a test</ssc:Content></ssc:MetaData>'
WHOLE = '<ssd:Connection startElement="one" startConnector="{0}" endElement="two" endConnector="{1}"/>'
ONE = WHOLE.replace(" endElement", ' startIndices="{2}" endElement').replace('"/>', '" endIndices="{3}"/>')
PUSH = '<ssd:Connection startConnector="push" endElement="one" endConnector="Float64.in"/>'
PULL = '<ssd:Connection startElement="two" startConnector="UInt64.out" {0} endConnector="{1}"/>'
PULLS = [PULL.format("", "pull"), PULL.format('startIndices="1"', "first")]
LINKS = [WHOLE.format("Float64.out", "Float64.in"), ONE.format("Int8.out", "UInt64.in", 2, 1), PUSH, *PULLS]
VALUES = gain_archives.value_set({
    "one.m": f'<ssv:Float64 value="6 5 4 3 2 1"/>{PAIR}<ssc:Dimension size="3"/>',
    "one.Int8.in": f'<ssv:Int8 value="-7 9"/>{PAIR}',
    "one.Boolean.in": f'<ssv:Boolean value="true 0"/>{PAIR}',
    "two.UInt32.in": f'<ssv:UInt32 value="4294967295 0"/>{PAIR}',
    "two.choice": '<ssv:Enumeration><ssv:Value value="far"/></ssv:Enumeration>',
})  # fmt: skip
AS_SYSTEM = """
[[connect]]
from = "one"
to = "two"
variables = { "Float64.out[1]" = "Float64.in[1]", "Float64.out[2]" = "Float64.in[2]", "Int8.out[2]" = "UInt64.in[1]" }
"""
AS_SETTINGS = {f"one.m[{i},{j}]": 10.0 - 3 * i - j for i in (1, 2) for j in (1, 2, 3)} | {
    "one.Int8.in[1]": -7, "one.Int8.in[2]": 9, "one.Boolean.in[1]": True, "one.Boolean.in[2]": False,
    "two.UInt32.in[1]": 4294967295, "two.UInt32.in[2]": 0, "two.choice": "far",
    "one.Float64.in[1]": 1, "one.Float64.in[2]": 2,  # what a signal has at first is sent
}  # fmt: skip


def array(name, kind, stated, dimension=PAIR):
    return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:{stated}/>{dimension}</ssd:Connector>'


def component(name, types=TYPES):
    ends = "".join(
        array(f"{k}.{way}", f"{way}put", s) for k, s in zip(TYPES, types, strict=True) for way in ("in", "out")
    )
    ends += array("columns", "structuralParameter", "UInt64", "")
    return gain_archives.component(name, "resources/Arrays3.fmu", ends, NOTE, 'implementation="CoSimulation"')


def structure(links=LINKS, values=VALUES, types=TYPES):
    ends = (
        array("push", "input", "Float64") + array("pull", "output", "UInt64") + array("first", "output", "UInt64", "")
    )
    bound = gain_archives.binding(f"<ssd:ParameterValues>{values}</ssd:ParameterValues>")
    root = gain_archives.system("two", ends, component("one") + component("two", types), "".join(links), bound)
    experiment = '<ssd:DefaultExperiment startTime="0" stopTime="0.01"/>'
    return gain_archives.structure(root, experiment=experiment).replace('version="1.0"', 'version="2.0"')


@pytest.fixture
def run(arrays3_fmu, tmp_path):
    """`run(**parts)`: what an archive of two such FMUs leads to."""

    def simulate(**parts):
        with zipfile.ZipFile(tmp_path / "two.ssp", "w") as content:
            content.writestr("SystemStructure.ssd", structure(**parts))
            content.write(arrays3_fmu, "resources/Arrays3.fmu")
        return amb_cosim.simulate(tmp_path / "two.ssp", step_size=1e-3, isolated=False)

    return simulate


def test_arrays_in_an_archive_and_in_a_system_file_are_equal(run, arrays3_fmu, tmp_path):
    path = write_system(tmp_path, dict.fromkeys(("one", "two"), arrays3_fmu), more=AS_SYSTEM)
    ours, theirs = amb_cosim.simulate(path, set=AS_SETTINGS, isolated=False).dataset, run().dataset
    names = [name for name in theirs if name.startswith(("one.", "two."))]
    xr.testing.assert_equal(ours[names], theirs[names])
    assert theirs["two.UInt64.out[1]"].values[-1] == 9
    assert theirs["one.sum"].values[-1] == 6 + 10 + 12 + 12 + 10 + 6
    assert theirs["two.chosen"].values[-1] == 70000
    assert {"push[1]", "push[2]"} <= set(theirs)
    assert [theirs[name].values[-1] for name in ("pull[1]", "pull[2]", "first")] == [
        9,
        theirs["two.UInt64.out[2]"][-1],
        9,
    ]


def test_a_contradiction_names_the_type_that_the_fmu_declares(run):
    result = run(types=("Float64", "Float32", "UInt64")).dataset
    (notice,) = json.loads(result.attrs["notices"])
    assert_names(notice, "two.Int8.in (Float32, in the FMU Int8)")


@pytest.mark.parametrize(("parts", "facts"), [
    ({"links": [WHOLE.format("Int8.out", "choice")]}, ("one.Int8.out[1]", "2 values", "two.choice", "1")),
    ({"links": [ONE.format("Int8.out", "Int8.in", 3, 1)]}, ("one.Int8.out", "[3]")),
    ({"values": VALUES.replace("6 5 4", "6 5")}, ("5 values", "one.m", "6")),
    ({"values": VALUES.replace("-7 9", "-7 9.5")}, ("one.Int8.in", "'-7 9.5'", "Int8")),
    ({"values": VALUES.replace("true 0", "true no")}, ("'true no'", "Boolean")),
    ({"values": VALUES.replace("Float64", "Float16")}, ("SSP 2.0", "Float16")),
    ({"values": VALUES.replace('value="6 5 4 3 2 1"', "")}, ("SSP 2.0", "line")),
])  # fmt: skip
def test_a_value_that_does_not_fit_an_array_is_refused_with_its_index(run, parts, facts):
    with raises_naming(ValueError, *facts):
        run(**parts)
