"""Scenarios as SSP archives: valid, complete, and the same run in this package, in libcosim and in FMPy."""

import tempfile
import zipfile
from pathlib import Path

import archive_runs
import fmpy.ssp
import pytest
import xmlschema
from fmpy.ssp.ssd import read_ssd
from host_marks import host_marks, in_host
from lxml import etree
from slow import slow_but_first

from amb_cosim.cosim.ssp import load_ssp
from amb_cosim.cosim.ssp.schema import NAMESPACES

SCENARIO = """
description = "An unbalanced rotor from rest, with an event"
Omega = "260 rad/s"
settle_cycles = {settle}
end_cycle = 3
coupling = "{coupling}"
communication_step = "250 us"
gradient = {gradient}

[inputs.rotor_contact]
"d1.u" = "{unbalance} g.m"

[inputs.rolac_controller]
rolac_enable = false

[parameters.rolac_controller]
prediction_time = 0 # it divides by differences of times, which FMPy and ecos sum up

[parameters.rotor_contact]
"rb?.mu" = 0.1
"contact.impact_law" = 0
"""
EVENTS = """
[[event]]
cycle = 1
set.rotor_contact."d1.u" = "20 g.m"

[[event]]
time = "15 ms"
set.rolac_controller.rolac_enable = true

[[speed]]
cycle = 2
Omega = "262 rad/s"

[[stop]]
variable = "rotor_contact.rb1.f_n"
above = "1 MN"
from_cycle = 1
hold_time = "1 ms"

[record]
every = 2
"""
JACOBI = SCENARIO.format(settle=0, coupling="jacobi", unbalance=25.5, gradient="true")
HELD = SCENARIO.format(settle=0, coupling="jacobi", unbalance=25.5, gradient="false")
LEAVING = JACOBI.replace('"rb?.mu" = 0.1', '"rb?.enabled" = false')  # no retainer keeps it within the air gap
SEQUENTIAL = SCENARIO.format(settle=1.5, coupling="gauss_seidel", unbalance=0.5, gradient="true") + EVENTS
EXAMPLES = Path(__file__).parents[2] / "examples" / "controllers"
CONTROLLED = """
description = "A compressor under a linear controller of a file, from rest with an unbalance"
rotor = "compressor"
Omega = "9000 rpm"
settle_cycles = 0
end_time = "10 ms"
coupling = "jacobi"
communication_step = 2e-5 # "20 us" has another last bit

[fmu]
rolac_controller = "{file}"

[parameters.amb_actuator]
force_law = "linear"
"*.turns_?" = 48
"*.pole_area_?" = "45 cm^2"
"*.gap_?" = "0.5 mm"
"*.bias_current_?" = "5 A"
"*.static_current_?" = "1.5 A"
"*.current_limit_?" = "11.5 A"

[inputs.rotor_contact]
"impeller3.u" = "3 g.m"
"""
SCHEMAS = Path(fmpy.ssp.__file__).parent / "schema"


@pytest.fixture(scope="module")
def sequential(archive):
    return archive("sequential", SEQUENTIAL)


@pytest.fixture(scope="module")
def jacobi(archive):
    """For libcosim and ecos, which have no Enumerations."""
    return archive("jacobi", JACOBI, integers=True)


@pytest.mark.parametrize("connectors", slow_but_first([False, True]))
def test_documents_follow_the_schemas_of_ssp(archive, sequential, connectors):
    path = archive("connectors", SEQUENTIAL, connectors=True) if connectors else sequential
    structure = xmlschema.XMLSchema(str(SCHEMAS / "SystemStructureDescription.xsd"))
    values = xmlschema.XMLSchema(str(SCHEMAS / "SystemStructureParameterValues.xsd"))
    with zipfile.ZipFile(path) as content:
        structure.validate(content.read("SystemStructure.ssd").decode())
        sets = [name for name in content.namelist() if name.endswith(".ssv")]
        for name in sets:
            values.validate(content.read(name).decode())
    assert len(sets) == 3


def test_only_connected_variables_are_connectors(sequential):
    """FMPy sets unconnected listed inputs to zero; libcosim refuses connectors of the system."""
    ssd = read_ssd(str(sequential)).system
    assert not ssd.connectors
    listed = {(c.name, connector.name) for c in ssd.elements for connector in c.connectors}
    ends = {
        end
        for link in ssd.connections
        for end in ((link.startElement, link.startConnector), (link.endElement, link.endConnector))
    }
    assert listed == ends
    assert ("rolac_controller", "mb1.i_x") in listed


def test_connectors_of_the_system_feed_the_same_inputs(archive, sequential):
    with_connectors, without = (
        load_ssp(path) for path in (archive("connectors", SEQUENTIAL, connectors=True), sequential)
    )
    assert with_connectors[0].signal("Omega") == without[0].signal("Omega")
    ends = {connector.name for connector in read_ssd(str(archive("connectors", SEQUENTIAL))).system.connectors}
    assert ends == {"Omega", "Omega_dot", "rotor_contact.d1.u", "rolac_controller.rolac_enable"}
    assert with_connectors[1:] == without[1:]


@pytest.mark.slow
@pytest.mark.parametrize(("integers", "kind"), [(False, "Enumeration"), (True, "Integer")])
def test_switches_are_enumerations_or_integers_throughout(sequential, jacobi, integers, kind):
    path = jacobi if integers else sequential
    with zipfile.ZipFile(path) as content, tempfile.TemporaryDirectory() as folder:
        document = etree.fromstring(content.read("resources/amb_actuator.ssv"))
        described = fmpy.read_model_description(content.extract("resources/amb_actuator.fmu", folder))
    bound = document.find(".//ssv:Parameter[@name='force_law']", NAMESPACES)[0]
    variable = next(v for v in described.modelVariables if v.name == "force_law")
    assert etree.QName(bound).localname == variable.type == kind
    items = {item.name: item.value for item in variable.declaredType.items} if variable.declaredType else {}
    assert items.get(bound.get("value"), bound.get("value")) == variable.start == "1"


def test_the_command_writes_the_same_archive(runner, sequential, tmp_path):
    (tmp_path / "rig.toml").write_text(SEQUENTIAL, encoding="utf-8")
    done = runner("export-ssp", "rig.toml", "-o", "rig.ssp")
    assert done.exit_code == 0, done.output
    assert (tmp_path / "rig.ssp").read_bytes() == sequential.read_bytes()


def test_only_components_with_longer_steps_have_annotations(runner, sequential, tmp_path):
    """OMSimulator refuses a component with annotations; libcosim has the step of one from there."""
    slow = '[[component]]\nname = "amb_actuator"\nfmu = "amb_actuator"\nevery = 2\n'
    (tmp_path / "slow.toml").write_text(f'base = "levitated"\n{slow}', encoding="utf-8")
    (tmp_path / "rig.toml").write_text(f'system = "slow.toml"\n{JACOBI}', encoding="utf-8")
    done = runner("export-ssp", "rig.toml", "-o", "rig.ssp")
    assert done.exit_code == 0, done.output
    result = []
    for path in (sequential, tmp_path / "rig.ssp"):
        with zipfile.ZipFile(path) as content:
            components = etree.fromstring(content.read("SystemStructure.ssd")).iterfind(".//ssd:Component", NAMESPACES)
            result.append({c.get("name") for c in components if c.find("ssd:Annotations", NAMESPACES) is not None})
        system, *_ = load_ssp(path)
        assert {c.name for c in system.components if c.every > 1} == result[-1]
    assert result == [set(), {"amb_actuator"}]


def test_content_that_ssp_cannot_express_is_in_the_notes(sequential):
    with zipfile.ZipFile(sequential) as content:
        notes = content.read("extra/amb-cosim/README.md").decode()
    assert "in the order rolac_controller, amb_actuator, rotor_contact" in notes
    assert "| 0.015 | rolac_controller.rolac_enable | True |" in notes
    assert "| rotor_contact.d1.u | 0.02 |" in notes
    assert "| Omega | `rotor_contact.Omega`, `rolac_controller.Omega` | 260.0 |" in notes
    assert "- rotor_contact.rb1.f_n above 1000000 N for 0.001 s" in notes


@pytest.mark.slow
@pytest.mark.parametrize("flavour", [pytest.param("native", marks=pytest.mark.gate), "python"])
def test_the_archive_runs_with_the_same_bits(run_python, run_once, archive, sequential, flavour):
    ours = run_once(archive_runs.with_this_project, scenario=SEQUENTIAL)
    path = sequential if flavour == "native" else archive(flavour, SEQUENTIAL, flavour=flavour)
    back = run_python(archive_runs.read_back, archive=str(path), timeout=600)
    assert ours.keys() == back.keys() - {"time"}
    assert {name for name in ours if ours[name] != back[name]} == set()
    assert max(ours["Omega"]) > 261.0
    assert set(ours["rolac_controller.rolac_enable"]) == {0, 1}


LINEAR = ("lead_notches", "cross_feedback")
# Scenario, its step (s), inputs that no tool records, and an output that shows contact or control.
CASES = {
    "jacobi": (JACOBI, 250e-6, ("d1.u", "rolac_enable"), ("rotor_contact.rb1.f_n", 1000.0)),
    **{
        name: (
            CONTROLLED.format(file=EXAMPLES / f"{name}.toml"),
            20e-6,
            "impeller3.u",
            ("rolac_controller.mb1.i_x", 0.1),
        )
        for name in LINEAR
    },
}
IN_HOSTS = [
    pytest.param("libcosim", "jacobi", marks=host_marks("libcosim", "SSP archive")),
    pytest.param("ecos", "jacobi", marks=host_marks("ecos", "SSP archive")),
    *(
        pytest.param(marks[1].args[0], name, marks=marks)
        for name in LINEAR
        for marks in (
            host_marks("libcosim", "SSP archive with a controller of a file"),
            host_marks("ecos", "SSP archive with a controller of a file"),
        )
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("host", "case"), IN_HOSTS)
def test_other_masters_run_the_archive_with_the_same_bits(run_python, run_once, archive, host, case):
    """libcosim has the outputs after each step alone, and not those of types that it lacks."""
    scenario, step, inputs, (shown, least) = CASES[case]
    first = 1 if host == "libcosim" else 0
    ours = run_once(archive_runs.with_this_project, scenario=scenario, nanoseconds=host == "libcosim")
    outputs = [name for name in ours if "." in name and not name.endswith(inputs)]
    values = {
        "archive": str(archive(case, scenario, integers=True)),
        "recorded": outputs,
        "steps": len(ours[shown]) - 1,
    }
    if host == "libcosim":
        theirs = run_python(archive_runs.with_libcosim, **values)
    else:
        theirs = run_python(archive_runs.with_ecos, **values, step_size=step)
    compared = {name: series for name, series in theirs.items() if series}
    assert len(compared) > 60 if host == "libcosim" else compared.keys() == {*outputs}
    assert {name for name, series in compared.items() if series != ours[name][first:]} == set()
    assert max(map(abs, ours[shown])) > least


@pytest.mark.slow
@in_host("FMPy", "SSP archive")
def test_fmpy_runs_the_archive_with_the_same_bits(run_python, run_once, archive):
    """ecos ignores the bindings and begins with inputs of zero, which is right for held forces."""
    path, ours = archive("held", HELD), run_once(archive_runs.with_this_project, scenario=HELD)
    steps = len(ours["rotor_contact.mb1.x"]) - 1
    theirs = run_python(archive_runs.with_fmpy, archive=str(path), stop_time=(steps - 0.5) * 250e-6, step_size=250e-6)
    names = [name for name in theirs if name in ours]
    assert len(names) > 20
    assert {name for name in names if theirs[name] != ours[name][1:]} == set()


@pytest.mark.slow
@in_host("libcosim", "SSP archive", "a fault ends the run with an error")
def test_libcosim_ends_with_an_error_at_a_fault(run_python, archive):
    path = archive("leaving", LEAVING, integers=True)
    assert run_python(archive_runs.ends_in_libcosim, archive=str(path), steps=10) == {
        "goes_on": True,
        "is_error": False,
    }
    assert run_python(archive_runs.ends_in_libcosim, archive=str(path), steps=2000) == {
        "goes_on": False,
        "is_error": True,
    }


@pytest.mark.slow
@in_host("ecos", "SSP archive", "it continues through a fault, which fault_code reports")
def test_ecos_continues_through_a_fault_reported_by_fault_code(run_python, archive):
    path, codes = archive("leaving", LEAVING, integers=True), "amb_actuator.fault_code"
    theirs = run_python(archive_runs.with_ecos, archive=str(path), recorded=[codes], steps=2000, step_size=250e-6)[
        codes
    ]
    first = next(n for n, code in enumerate(theirs) if code)
    assert first > 10
    assert set(theirs[first:]) == {theirs[first]}


@pytest.mark.parametrize(("platforms", "unknown"), [("amiga", "amiga"), ("linux64, wasm64", "wasm64")])
def test_an_archive_for_an_unknown_platform_is_refused_and_not_written(refuses, platforms, unknown):
    refuses(unknown, "export-ssp", "nelson_mcvaugh_rub", "--platform", platforms, "-o", "case.ssp")
