"""FMUs of FMI 3.0: arrays element by element, every number type, and the same outcomes as of FMI 2.0."""

import numpy as np
import pytest
import xarray as xr
from fmu_systems import write_system

import amb_cosim
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.fmus import provide
from amb_cosim.cosim.record.warnings import warnings_of
from tests.support.messages import assert_names, raises_naming
from tests.support.reference_results import table, verified_with

GOOD, END, EARLY, MINUS_ONE, WARN, FAIL = range(6)
INTEGERS = [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
KINDS = ["Float64", "Float32", *INTEGERS, "Boolean"]
ALL = """
[[connect]]
from = "one"
to = "two"
variables = {{ {} }}
""".format(", ".join(f'"{k}.out[{j}]" = "{k}.in[{j}]"' for k in KINDS for j in (1, 2)))


@pytest.fixture
def run(arrays3_fmu, tmp_path):
    """`run(event, connections)`: what both loops find for two such FMUs, which is the same."""

    def simulate(event, connections=ALL, **options):
        path = write_system(tmp_path, dict.fromkeys(("one", "two"), arrays3_fmu), event=event, more=connections)
        runs = [amb_cosim.simulate(path, loop=loop, isolated=False, **options) for loop in ("compiled", "plain")]
        compiled, plain = runs
        xr.testing.assert_equal(compiled.dataset, plain.dataset)
        assert compiled.outcome == plain.outcome
        assert warnings_of(compiled.dataset) == warnings_of(plain.dataset)
        return compiled

    return simulate


@pytest.fixture(scope="module")
def ports(arrays3_fmu):
    return read_interface(provide(str(arrays3_fmu)).folder, "one").ports


def test_an_array_becomes_its_elements_row_by_row(ports):
    assert [name for name in ports if name.startswith("m[")] == [f"m[{i},{j}]" for i in (1, 2) for j in (1, 2, 3)]
    result = [ports[f"m[{i},{j}]"] for i in (1, 2) for j in (1, 2, 3)]
    assert [port.start for port in result] == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert {port.reference for port in result} == {101}
    assert {port.type for port in ports.values()} == {"Real", "Integer", "Boolean"}
    assert [ports[f"Boolean.in[{j}]"].start for j in (1, 2)] == [0.0, 1.0]


def test_strings_clocks_and_clocked_variables_are_no_ports(ports):
    assert {"text", "tick", "ticked", "time"}.isdisjoint(ports)


def test_values_of_every_type_are_passed_between_fmus(run):
    values = {"Float64": 0.1, "Float32": 0.1, "Int8": -128, "UInt8": 255, "Int16": -32768, "UInt16": 65535}
    values |= {"Int32": -(2**31), "UInt32": 2**32 - 1, "Int64": -(2**53), "UInt64": 2**53}
    event = ", ".join(f'"one.{kind}.in[2]" = {value}' for kind, value in values.items())
    result = run(event + ', "one.Boolean.in[1]" = true, "one.choice" = 70000').dataset
    for kind, value in values.items():
        expected = np.float32(value) if kind == "Float32" else value
        assert result[f"two.{kind}.out[2]"].values[[4, -1]].tolist() == [2, expected]
        assert set(result[f"two.{kind}.out[1]"].values[1:]) == {1}, "the other element keeps its start value"
    assert result["two.Boolean.out[1]"].values[[4, -1]].tolist() == [False, True]
    assert result["one.chosen"].values[[4, -1]].tolist() == [1, 70000]


def test_unconnected_elements_keep_their_start_values(run):
    half = ALL.replace('"Int8.out[1]" = "Int8.in[1]",', "")
    settings = {"two.Int8.in[1]": 7, "one.m[2,1]": 0.0}
    result = run('"one.Int8.in[2]" = 3', half, set=settings).dataset
    assert result["two.Int8.out[1]"].values[-1] == 7
    assert result["two.Int8.out[2]"].values[-1] == 3
    assert result["one.sum"].values[-1] == 1 + 4 + 9 + 25 + 36
    assert result["two.sum"].values[-1] == 91


@pytest.mark.parametrize(
    ("what", "status", "facts"),
    [
        (END, "stopped", ("one", "ended the run", "terminateSimulation")),
        (EARLY, "failed", ("fmi3DoStep", "Discard", "early")),
        (MINUS_ONE, "failed", ("fmi3DoStep", "-1", "FMI")),
        (FAIL, "failed", ("fmi3DoStep", "Error", "it is hot")),
        (WARN, "completed", ()),
    ],
)
def test_status_of_a_step_ends_the_run_or_warns(run, what, status, facts):
    result = run(f'"one.what" = {what}')
    assert result.outcome.status == status
    if facts:
        assert_names(result.outcome.reason, *facts)
    assert bool(result.outcome.reason) == bool(facts)
    assert [w.sentence for w in warnings_of(result.dataset)] == (["it is warm, 100 %"] if what == WARN else [])


def test_a_value_beyond_the_range_of_its_type_is_refused(run):
    narrow = '[[connect]]\nfrom = "one"\nto = "two"\nvariables = { "Int16.out[1]" = "Int8.in[2]" }'
    outcome = run('"one.Int16.in[1]" = 128', narrow).outcome
    assert (outcome.status, outcome.component, outcome.time) == ("failed", "two", 0.005)
    assert_names(outcome.reason, "fmi3Set", "Error", "128", "integer")
    with raises_naming(ValueError, "one.Int8.in[1]", "128", ">= -128", "<= 127"):
        run('"one.Int8.in[1]" = 128')


@pytest.mark.parametrize(("source", "target"), [("Float32", "Int8"), ("Int16", "Boolean"), ("Boolean", "Float64")])
def test_unlike_types_are_named_as_the_fmus_declare_them(run, source, target):
    """They were Real, Integer and Boolean, as of FMI 2.0."""
    unlike = f'[[connect]]\nfrom = "one"\nto = "two"\nvariables = {{ "{source}.out[1]" = "{target}.in[2]" }}'
    with raises_naming(ValueError, f"one.{source}.out[1] is {source}", f"two.{target}.in[2] is {target}"):
        run('"one.Int8.in[2]" = 1', unlike)


def test_iterative_coupling_restores_states_of_fmi_3(run, tmp_path):
    explicit = run('"one.Float64.in[1]" = 3').dataset
    again, text = tmp_path / "again.toml", (tmp_path / "system.toml").read_text(encoding="utf-8")
    again.write_text(f'coupling = "iterative"\n{text}', encoding="utf-8")
    iterative = amb_cosim.simulate(again, isolated=False).dataset
    assert iterative["two.Float64.out[1]"].values[-1] == explicit["two.Float64.out[1]"].values[-1] == 3


@pytest.mark.parametrize("option", ["coupling", "rotor", "stop"])
def test_an_option_that_no_model_takes_is_refused(arrays3_fmu, tmp_path, option):
    with raises_naming(ValueError, option, "there are none"):
        amb_cosim.simulate(write_system(tmp_path, {"one": arrays3_fmu}), **{option: "iterative"})


def test_references_without_an_experiment_use_the_default_experiment(arrays3_fmu, tmp_path):
    """As FMUs carry them that are not this project's: a table alone, with texts in it, which are no numbers."""
    rows = ["1 2 3 4 5 6,0,a", "1 2 3 4 5 6,91,a", "1 2 3 4 5 6,90,a"]
    item = verified_with(arrays3_fmu, tmp_path / "Arrays3.fmu", {"out.csv": table("m,sum,text", rows)})
    assert (item.experiment, item.n_points, item.n_values) == ("out", 3, 3 * 7)
    largest = item.largest
    assert (largest.variable, largest.time, largest.expected, largest.computed) == ("sum", 0.2, 90.0, 91.0)
