"""Descriptions that break rules of FMI in ways that other importers accept are read, with a notice of each rule."""

import json
import zipfile
from pathlib import Path

import pytest
from fmu_systems import write_system

import amb_cosim
from amb_cosim.cosim.errors import StartFailed
from amb_cosim.cosim.fmu.fmu_description import read_interface
from tests.support.changed_archive import changed_archive
from tests.support.messages import assert_names, raises_naming

SOURCE = Path(__file__).parents[1] / "ssp" / "gain.c"
VALID = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Gain" guid="{gain}">
<CoSimulation modelIdentifier="gain" canHandleVariableCommunicationStepSize="true"/>
<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions>
<TypeDefinitions><SimpleType name="State"><Enumeration><Item name="off" value="1"/></Enumeration></SimpleType>
</TypeDefinitions>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1" unit="m"/></ScalarVariable>
<ScalarVariable name="y" valueReference="1" causality="output"><Real unit="m"/></ScalarVariable>
<ScalarVariable name="k" valueReference="2" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
<ScalarVariable name="state" valueReference="3" causality="input" variability="discrete">
<Enumeration declaredType="State" start="1"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture
def read(tmp_path):
    """`read(old, new)`: the interface of the FMU if one text in its description is another."""

    def interface(old="", new=""):
        assert VALID.count(old) == 1 or not old
        (tmp_path / "modelDescription.xml").write_text(VALID.replace(old, new) if old else VALID, encoding="utf-8")
        return read_interface(tmp_path, "one")

    return interface


@pytest.mark.parametrize("identifier", ["tank-c", "2nd", "a.b", "größe"])
def test_an_identifier_that_is_no_name_in_c_is_a_notice(fmu_from_c, tmp_path, identifier):
    # As in FMUs of Maestro's tests (watertank-c, rollback-end).
    source = fmu_from_c(SOURCE, VALID, name="identified")
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(tmp_path / "one.fmu", "w") as new:
        for name in old.namelist():
            content = old.read(name).replace(b'Identifier="gain"', f'Identifier="{identifier}"'.encode())
            new.writestr(name.replace("gain.so", f"{identifier}.so"), content)
    data = amb_cosim.simulate(write_system(tmp_path, {"one": "one.fmu"}), isolated=False).dataset
    assert data["one.y"].values[-1] == 1.0
    (notice,) = json.loads(data.attrs["notices"])
    assert_names(notice, "one", "modelIdentifier", identifier, "name in C")


def test_a_valid_description_breaks_no_rule(read):
    assert read().deviations == ()


@pytest.mark.parametrize(
    ("old", "new", "facts"),
    [
        ('causality="input" variability="discrete"', 'causality="input"', ('"state"', "Enumeration", "variability")),
        (' variability="fixed"', "", ('"k"', "parameter", "continuous")),
        ('declaredType="State"', 'declaredType="Mode"', ('"state"', '"Mode"')),
        ('start="1" unit="m"', 'start="1" unit="yard"', ('"yard"', '"u"')),
        ('start="1" unit="m"', 'start="1" unit="m" displayUnit="inch"', ('"inch"', '"u"')),
        ('start="1" unit="m"', 'unit="m"', ('"u"', "start value")),
        ('<Real unit="m"/>', '<Real unit="m" start="3"/>', ('"y"', "start value")),
        ('guid="{gain}"', 'guid="{gain}" maker="me"', ("'maker'", "line 2")),
        ("<ModelVariables>", "<Maker/><ModelVariables>", ("Maker", "line 7")),
        ("<ModelStructure>", "<ModelStructure><Maker/>", ("Maker",)),
        ('fmiVersion="2.0"', 'fmiVersion="2.0.1"', ("2.0.1",)),
        ('<Unknown index="2"/>', '<Unknown index="2"/><Unknown index="9"/>', ("index",)),
    ],
)
def test_notice_names_the_violated_rule(read, old, new, facts):
    interface = read(old, new)
    assert_names(" ".join(interface.deviations).replace("(", " ").replace(")", " "), *facts)
    assert set(interface.ports) == {"u", "y", "k", "state"}
    assert interface.ports["k"].causality == "parameter"


@pytest.mark.parametrize(
    ("old", "new", "facts"),
    [
        (' guid="{gain}"', "", ("readable", "'guid'")),
        (' modelIdentifier="gain"', "", ("readable", "'modelIdentifier'")),
        ('name="k" valueReference="2"', 'name="k"', ("readable", "line 10", "'valueReference'")),
        ('name="k" ', 'name="y" ', ("readable", "'y'", "2 variables")),
        ('start="1" unit="m"', 'start="one" unit="m"', ("readable", "'one'")),
        ("</ModelVariables>", "", ("readable",)),
    ],
)
def test_a_description_that_cannot_be_parsed_is_refused(read, old, new, facts):
    with raises_naming(ValueError, "one", *facts):
        read(old, new)


def test_an_archive_with_an_enclosing_folder_is_refused_with_its_name(tmp_path):
    (tmp_path / "Gain").mkdir()
    (tmp_path / "Gain" / "modelDescription.xml").write_text(VALID, encoding="utf-8")
    with raises_naming(ValueError, "one", "no modelDescription.xml", "Gain"):
        read_interface(tmp_path, "one")


@pytest.fixture
def system(fmu_from_c, tmp_path):
    """`system(description, **more)`: path of a system of the FMU alone, with more files in it."""

    def write(description, more=()):
        whole = fmu_from_c(SOURCE, VALID, name="deviating")
        changed_archive(whole, tmp_path / "one.fmu", {"modelDescription.xml": description, **dict(more)})
        return write_system(tmp_path, {"one": "one.fmu"})

    return write


def test_an_fmu_that_breaks_rules_runs_with_a_notice(system):
    """As Simulink R2016b wrote Enumeration inputs, and FMPy refuses them."""
    text = VALID.replace('causality="input" variability="discrete"', 'causality="input"')
    result = amb_cosim.simulate(system(text), set={"one.k": 3.0}, isolated=False)
    assert result.dataset["one.y"].values[-1] == 3.0
    (notice,) = json.loads(result.dataset.attrs["notices"])
    assert_names(notice, "one", "modelDescription.xml", '"state"', "Enumeration")


def test_an_fmu_that_cannot_be_loaded_is_named(system):
    path = system(VALID)
    with zipfile.ZipFile(path.parent / "one.fmu", "w") as fmu:
        fmu.writestr("modelDescription.xml", VALID)
        fmu.writestr("binaries/linux64/gain.so", b"no library")
    with raises_naming(StartFailed, "one", "loading", "gain.so"):
        amb_cosim.simulate(path, isolated=False)


@pytest.mark.parametrize("name", ["./modelDescription.xml", ".//modelDescription.xml"])
def test_a_second_description_is_refused_unless_it_is_the_same(system, name):
    amb_cosim.simulate(system(VALID, [(name, VALID)]), isolated=False)
    with raises_naming(ValueError, "one.fmu", "two different entries", "modelDescription.xml", name):
        amb_cosim.simulate(system(VALID, [(name, VALID.replace('start="1"', 'start="2"'))]), isolated=False)


def test_names_with_the_separators_of_windows_are_read(fmu_from_c, tmp_path):
    r"""As `binaries\linux64\gain.so`; names that lead out of the archive are refused in both spellings."""
    whole, path = fmu_from_c(SOURCE, VALID, name="deviating"), write_system(tmp_path, {"one": "one.fmu"})
    for more in ((), ("..\\out.txt",)):
        with zipfile.ZipFile(whole) as source, zipfile.ZipFile(tmp_path / "one.fmu", "w") as target:
            for name in (*source.namelist(), *more):
                entry = zipfile.ZipInfo(name)
                entry.filename = name.replace("/", "\\")
                target.writestr(entry, b"" if name in more else source.read(name))
        if not more:
            assert amb_cosim.simulate(path, isolated=False).dataset["one.y"].values[-1] == 1.0
        else:
            with raises_naming(ValueError, "one.fmu", "../out.txt"):
                amb_cosim.simulate(path, isolated=False)
