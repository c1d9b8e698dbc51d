"""FMI 3.0: the same cores behind a second face, with arrays."""

import dataclasses
import math
import shutil
import zipfile
from ctypes import byref, c_bool, c_double, c_size_t, c_uint32, c_void_p

import fmpy
import numpy as np
import pytest
from instances import initialised
from raw import ERROR, OK, Library3

from amb_cosim.cosim.fmu.fmu_description import read_interface
from fmi_export.building.arrays import lengths, slots
from fmi_export.building.description3 import model_description3
from fmi_export.building.native.package import build_native_fmu
from fmi_export.interface import Interface, interface
from fmi_export.variables import output
from tests.support.messages import assert_names, raises_naming


@pytest.fixture(scope="module")
def library(unpacked, matrix):
    return Library3(unpacked(matrix, None, None, 3))


def test_whole_arrays_are_set_and_read_together_with_scalars(library, matrix):
    u, gains = [1.5, -2.0, 4.0], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]
    core = initialised(matrix, np.zeros(1), {f"u{j}": value for j, value in enumerate(u)})
    with library.instantiate().begin(u=u, n=[3, -4], on=[True, False]) as fmu:
        assert fmu.get("f") == [core["f0"], core["f1"]] == [-2.0 + 8.0, 15.0 - 22.0 + 48.0]
        assert fmu.get("twice", "off") == [6, -8, False, True]
        assert fmu.set(gains=[*gains[0], *gains[1]]) == OK
        assert fmu.step(0) == OK
        assert fmu.get("f", "elapsed") == [*np.array(gains) @ u, 250e-6]
        expected = [[[u[i] * u[j], u[i] - u[j]] for j in range(2)] for i in range(2)]
        assert np.reshape(fmu.get("z"), (2, 2, 2)).tolist() == expected
        (f, _, _), (time, _, _), (z, _, _) = (library.variables[name] for name in ("f", "time", "z"))
        values = [0.0] * 11
        assert fmu.transfer("Get", "Float64", [f, time, z], values) == OK
        assert values == [*fmu.get("f"), 250e-6, *fmu.get("z")]


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda f: f.transfer("Get", "Float64", [7], [0.0] * 2), ("fmi3GetFloat64", "3 values", "2")),
        (lambda f: f.transfer("Set", "Float64", [7], [0.0] * 4), ("fmi3SetFloat64", "3 values", "4")),
        (lambda f: f.transfer("Get", "Float64", [8], [0.0]), ("fmi3GetFloat64", "u1", "array")),
        (lambda f: f.transfer("Get", "Float64", [10], [0.0]), ("fmi3GetFloat64", "n0", "Integer")),
        (lambda f: f.transfer("Get", "Float64", [31], [0.0]), ("fmi3GetFloat64", "31")),
        (lambda f: f.transfer("Get", "Int32", [30], [0]), ("fmi3GetInt32", "30")),
        (lambda f: f.transfer("Set", "Float64", [30], [1.0]), ("fmi3SetFloat64", "time")),
        (
            lambda f: f.call("GetFloat32", byref(c_uint32(0)), c_size_t(1), None, c_size_t(1)),
            ("fmi3GetFloat32", "limit"),
        ),
        (lambda f: f.call("SetString", byref(c_uint32(9)), c_size_t(1), None, c_size_t(1)), ("fmi3SetString", "u2")),
        (lambda f: f.call("GetClock", byref(c_uint32(99)), c_size_t(1), None), ("fmi3GetClock", "99")),
    ],
)
def test_a_wrong_argument_is_refused_with_the_reason(library, call, facts):
    assert [library.variables[name][0] for name in ("limit", "u", "n", "elapsed", "time")] == [0, 7, 10, 14, 30]
    with library.instantiate().begin() as fmu:
        assert call(fmu) == ERROR
        assert [(status, category) for status, category, _ in fmu.log] == [(3, "logStatusError")]
        assert_names(fmu.log[0][2], *facts)
        assert (fmu.get("fault_code"), fmu.step(0)) == ([998], ERROR)


def test_a_fault_is_an_error_and_requests_no_termination(library):
    with library.instantiate().begin(u=[1.0, 2.0, 3.0]) as fmu:
        assert fmu.do_step(0.0, 1e-3) == (OK, [False] * 3, 1e-3)
        before = fmu.get("f", "elapsed", "time")
        fmu.set(u=[6.0, 0.0, 0.0])
        assert fmu.do_step(1e-3, 1e-3) == (ERROR, [False] * 3, 1e-3)
        sentence = "at t = 0.001 s: u0 = 6 m is above 5 m, 100 % ##1"
        assert fmu.log == [(ERROR, "logStatusError", sentence)], "a number sign is doubled, a percent sign is not"
        assert fmu.get("f", "elapsed", "time", "fault_code") == [*before, 1]


def test_a_resource_path_is_no_uri(library, tmp_path):
    place = tmp_path / "100%25 of it"
    shutil.copytree(library.resources, place)
    with library.instantiate(resources=f"{place}/") as fmu:
        assert fmu.begin().step(0) == OK


ABSENT = (
    *("GetIntervalDecimal", "GetIntervalFraction", "GetShiftDecimal", "GetShiftFraction", "SetIntervalDecimal"),
    *("SetIntervalFraction", "SetShiftDecimal", "SetShiftFraction", "EnterEventMode", "EnterStepMode"),
    *("EvaluateDiscreteStates", "UpdateDiscreteStates", "EnterConfigurationMode", "ExitConfigurationMode"),
    *("GetNumberOfVariableDependencies", "GetVariableDependencies"),
    *("GetOutputDerivatives", "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetTime", "SetContinuousStates"),
    *("GetContinuousStateDerivatives", "GetEventIndicators", "GetContinuousStates", "GetNominalsOfContinuousStates"),
    *("GetNumberOfEventIndicators", "GetNumberOfContinuousStates", "ActivateModelPartition"),
)


def test_unsupported_functions_are_refused_with_the_reason(library):
    with library.instantiate().begin() as fmu:
        zeros = [c_void_p()] * 8
        assert [fmu.call(function, *zeros) for function in ABSENT] == [ERROR] * len(ABSENT)
        assert [text.partition(": ")[0] for _, _, text in fmu.log] == [f"fmi3{function}" for function in ABSENT]
        assert fmu.step(0) == OK
        for kind in ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "UInt64", "String"):
            assert fmu.call(f"Get{kind}", None, c_size_t(0), None, c_size_t(0)) == OK
        assert fmu.call("DoStep", c_double(250e-6), c_double(250e-6), c_bool(False), None, None, None, None) == OK
        assert fmu.call("GetString", None, c_size_t(1), None, c_size_t(1)) == ERROR
        assert_names(fmu.log[-1][2], "fmi3GetString", "references", "NULL")
    nobody = library.instantiate(guid="{0}")
    for function in (*ABSENT, "GetInt64", "SetInt64", "GetString"):
        assert nobody.call(function, *zeros) == ERROR
    assert nobody.call("DoStep", *[c_double(1.0)] * 2, c_bool(False), *[None] * 3, byref(c_double())) == ERROR
    for kind in ("ModelExchange", "ScheduledExecution"):
        assert getattr(library.c, f"fmi3Instantiate{kind}")(*[c_void_p()] * 10) is None


def test_an_enumeration_is_read_and_set_as_a_long_integer(library_of):
    library = library_of("native 3")
    with library.instantiate() as fmu:
        reference, _, _ = library.variables["offset"]
        assert fmu.transfer("Set", "Int64", [reference], [-3]) == OK
        values = [0]
        assert fmu.transfer("Get", "Int64", [reference], values) == OK
        assert values == fmu.get("offset") == [-3]


@pytest.mark.parametrize(
    "name", ["probe_matrix", "probe_lag", "rotor_contact", "amb_actuator", "rolac_controller", "levitated_rotor"]
)
def test_the_description_is_valid_and_importable(name, tmp_path, lag, matrix):
    from xml.etree import ElementTree

    from fmpy import read_model_description
    from fmpy.validation import validate_model_description

    from amb_cosim.cosim.fmu.fmus import model_source

    model = {"probe_matrix": matrix, "probe_lag": lag}.get(name) or model_source(name)[0]
    path = tmp_path / "modelDescription.xml"
    path.write_bytes(ElementTree.tostring(model_description3(model, "{}", "a tool", "1"), xml_declaration=True))
    description = read_model_description(str(tmp_path), validate=True)
    assert validate_model_description(description) == []
    table = model.interface
    variables = [v for v in description.modelVariables if v.causality != "independent"]
    assert sum(math.prod(int(d.start) for d in v.dimensions) for v in variables) == len(table.variables)
    for v in variables:
        first = table.variables[v.valueReference]
        assert (v.unit or "1", v.causality, v.variability) == (first.unit, first.causality, first.variability)
        if first.causality != "output":
            size = len(v.start.split())
            starts = [1.0 if s == "true" else 0.0 if s == "false" else float(s) for s in v.start.split()]
            assert starts == table.start[v.valueReference : v.valueReference + size].tolist()


def test_sensors_and_receptance_of_the_rig_are_arrays():
    from amb_cosim.cosim.fmu.fmus import model_source

    def arrays(name):
        return {slot.name: slot.shape for slot in slots(model_source(name)[0].interface) if slot.shape}

    assert arrays("rotor_contact") == {"sensors": (8,)}
    assert arrays("amb_actuator") == {}
    assert arrays("rolac_controller") == {
        "sensor_weights": (8,),
        "sensor_scales": (8,),
        "plane_positions": (4,),
        "plane_offsets": (4,),
        "sensors": (8,),
        "receptance": (8, 4, 2),
    }


def test_warnings_and_element_names_are_in_a_separate_file(unpacked, lag, matrix):
    """FMI Library calls the element Annotation of FMI 3.0 unknown."""
    for model in (lag, matrix):
        folder = unpacked(model, None, None, 3)
        assert b"Annotation" not in (folder / "modelDescription.xml").read_bytes()
        ports = read_interface(folder, model.name).ports
        assert [(p.name, p.description, p.warning, p.over_step, p.position) for p in ports.values()] == [
            (v.name, v.description, v.warning, v.over_step, k) for k, v in enumerate(model.interface.variables)
        ]
    assert any(v.warning for v in lag.interface.variables)


def test_an_output_array_has_the_dependencies_of_its_elements(matrix):
    root = model_description3(matrix, "{}", "a tool", "1")
    reference = {v.get("name"): v.get("valueReference") for v in root.iterfind("ModelVariables/*")}
    result = {o.get("valueReference"): o.get("dependencies") for o in root.iterfind("ModelStructure/Output")}
    assert [result[reference[name]] for name in ("f", "twice", "elapsed")] == [reference["u"], reference["n"], ""]


def test_without_arrays_each_value_has_a_reference_as_in_fmi_2(matrix, library, tmp_path):
    path = build_native_fmu(matrix, np.zeros(1), tmp_path, fmi=3, arrays=False)
    assert not any(v.dimensions for v in fmpy.read_model_description(str(path)).modelVariables)
    zipfile.ZipFile(path).extractall(tmp_path / "extracted")
    scalars = Library3(tmp_path / "extracted")
    names = [v.name for v in matrix.interface.variables]
    assert scalars.variables.keys() == {*names, "time"}
    assert [scalars.variables[name][::2] for name in names] == [(n, 1) for n in range(len(names))]
    u, n, on = [1.5, -2.0, 4.0], [3, -4], [True, False]
    with scalars.instantiate() as alone, library.instantiate() as whole:
        alone.begin(**{f"{name}{j}": v for name, of in (("u", u), ("n", n), ("on", on)) for j, v in enumerate(of)})
        whole.begin(u=u, n=n, on=on)
        assert (alone.step(0), whole.step(0)) == (OK, OK)
        assert alone.get("f0", "f1", "elapsed") == whole.get("f", "elapsed")
        assert len(set(alone.get("f0", "f1"))) == 2


def test_variables_that_make_no_array_are_refused(matrix):
    table = matrix.interface
    assert lengths(table)[:10] == [1, 6, 0, 0, 0, 0, 0, 3, 0, 0]
    other = [dataclasses.replace(v, unit="mm") if v.name == "u1" else v for v in table.variables]
    with raises_naming(ValueError, "u", "u0"):
        slots(Interface(tuple(other)))
    gap = tuple(v for v in table.variables if v.name != "g01")
    with raises_naming(ValueError, "5 variables", "gains", "(2, 3)"):
        slots(Interface(gap))
    twice = output("f", "N", "A second one")
    with raises_naming(ValueError, "two", "FMI 3.0", "f"):
        slots(interface(twice, table.variables))


def test_libraries_and_icon_are_in_the_folders_of_fmi_3(lag, tmp_path, monkeypatch):
    from fmi_export.building.native import package
    from fmi_export.building.native.engines import Engine

    monkeypatch.setattr(package, "engine", lambda model, platform: Engine(platform.encode(), "a compiler"))
    monkeypatch.setattr(package, "documentation", lambda model: {"model.png": b"icon", "documentation/index.html": b""})
    with zipfile.ZipFile(package.build_native_fmu(lag, np.zeros(1), tmp_path, ["all"], 3)) as fmu:
        names = set(fmu.namelist())
        result = {name: fmu.read(name) for name in names if name.startswith("binaries/")}
    assert result == {
        "binaries/x86_64-linux/probe_lag.so": b"linux64",
        "binaries/x86_64-windows/probe_lag.dll": b"win64",
        "binaries/x86_64-darwin/probe_lag.dylib": b"darwin64",
        "binaries/aarch64-linux/probe_lag.so": b"aarch64-linux",
        "binaries/aarch64-darwin/probe_lag.dylib": b"aarch64-darwin",
    }
    assert {"terminalsAndIcons/icon.png", "documentation/index.html"} < names
    assert "model.png" not in names


def test_python_flavour_of_fmi_3_is_refused(tmp_path):
    import amb_cosim

    with raises_naming(ValueError, "FMI 3.0", "native"):
        amb_cosim.build(tmp_path, "python", fmi=3)
    assert list(tmp_path.iterdir()) == []
