"""FMUs that end a run by themselves, within a step: the record and the comparison of `verify` end at that time.

FMI 2.0 has values at fmi2LastSuccessfulTime after fmi2Discard with fmi2Terminated, FMI 3.0 at lastSuccessfulTime.
"""

from pathlib import Path

import pytest
from slow import slow_but_first

import amb_cosim
from tests.support.c_fmus import OUTPUT, PARAMETER, described
from tests.support.fmu_systems import write_system
from tests.support.messages import assert_names
from tests.support.reference_results import verified_with

SOURCE = Path(__file__).parent / "support" / "ending.c"
VARIABLES = [(name, PARAMETER, 'Real start="0"') for name in ("end", "kind")]
VARIABLES += [("y", OUTPUT, "Real"), ("said", f'{OUTPUT} variability="discrete"', "String")]
DESCRIPTIONS = {version: described("Ending", VARIABLES, version) for version in (2, 3)}
EXPERIMENT = """<Experiments><Experiment name="one" stopTime="0.4" stepSize="0.1">
<Parameters type="application/x-ssp-parameter-set" source="set.ssv"/><References type="text/csv" source="out.csv"/>
</Experiment></Experiments>"""
SET = (
    '<s><Parameter name="end"><Real value="0.25"/></Parameter><Parameter name="kind"><Real value="{}"/></Parameter></s>'
)
AT_STEPS = "time,y,said\n0,0,runs\n0.1,0.1,runs\n0.2,0.2,runs\n"


@pytest.fixture
def verified(fmu_from_c, tmp_path):
    """`verified(version, references, kind=0)`: the result for an FMU that ends at 0.25 s; `ending.c` has the kinds."""

    def verify(version, references, kind=0):
        fmu = fmu_from_c(SOURCE, DESCRIPTIONS[version], version)
        files = {"one.exp": EXPERIMENT, "set.ssv": SET.format(kind), "out.csv": references}
        return verified_with(fmu, tmp_path / "Ending.fmu", files)

    return verify


@pytest.mark.parametrize("version", slow_but_first([2, 3]))
def test_the_last_values_are_those_of_the_time_at_which_an_fmu_ends(verified, version):
    whole = verified(version, AT_STEPS + "0.25,0.25,over\n")
    assert (whole.is_equal, whole.n_values, whole.largest) == (True, 8, None)
    assert verified(version, AT_STEPS).is_equal
    held = verified(version, AT_STEPS + "0.3,0.25,over\n")
    assert not held.is_equal
    assert_names(held, "ended", "0.25 s", "0.3 s")


@pytest.mark.slow
@pytest.mark.parametrize("version", [2, 3])
def test_a_deviation_in_the_last_values_is_reported(verified, version):
    assert_names(verified(version, AT_STEPS + "0.25,0.24,over\n"), "NOT equal", "y = 0.25", "0.24", "0.25 s")
    assert_names(verified(version, AT_STEPS + "0.25,0.25,runs\n"), "NOT equal", "said = 'over'", "0.25 s")


@pytest.mark.parametrize("kind", slow_but_first([1, 2]))
def test_an_end_without_a_time_is_at_the_last_complete_step(verified, kind):
    """The FMU states no time, or 0 s, which is before the step that began at 0.2 s."""
    late = verified(2, AT_STEPS + "0.25,0.25,over\n", kind)
    assert not late.is_equal
    assert_names(late, "ended", "0.2 s", "0.25 s")


def test_a_discarded_step_without_termination_fails(verified):
    item = verified(2, AT_STEPS + "0.3,0.3,runs\n", kind=3)
    assert not item.is_equal
    assert_names(item, "failed", "discarded", "0.2 s")


@pytest.fixture
def simulated(fmu_from_c, tmp_path):
    """`simulated(ends, version, order, **options)`: a run of 0.4 s in steps of 0.1 s, of FMUs that end it at `ends`."""

    def simulate(ends, version=2, order="gauss_seidel", h=0.1, kind=0, flags="", **options):
        described = DESCRIPTIONS[version].replace("<CoSimulation ", f"<CoSimulation {flags} ")
        fmu = fmu_from_c(SOURCE, described, version)
        path = write_system(tmp_path, dict.fromkeys(ends, fmu), end="0.4 s", step=f"{h} s", coupling=order)
        settings = {f"{name}.end": end for name, end in ends.items()} | {f"{name}.kind": kind for name in ends}
        return amb_cosim.simulate(path, set=settings, **({"isolated": False} | options))

    return simulate


def times_and_values(result, name):
    data = result.dataset
    return data["time"].values.tolist(), data[f"{name}.y"].values.tolist()


@pytest.mark.parametrize("loop", ["compiled", "plain"])
@pytest.mark.parametrize("version", slow_but_first([2, 3]))
def test_an_fmu_that_ends_its_run_stops_it_at_its_time(simulated, version, loop):
    result = simulated({"one": 0.25}, version, loop=loop)
    assert (result.outcome.status, result.outcome.time, result.outcome.failure) == ("stopped", 0.25, None)
    assert_names(result.outcome, "one", "ended", "0.25 s", "fmi2Terminated" if version == 2 else "terminateSimulation")
    assert times_and_values(result, "one") == ([0.0, 0.1, 0.2, 0.25],) * 2


@pytest.mark.parametrize("kind", [1, 2])
@pytest.mark.parametrize("loop", slow_but_first(["compiled", "plain"]))
def test_a_run_that_ends_at_an_unknown_time_has_complete_steps(simulated, kind, loop):
    result = simulated({"one": 0.25}, kind=kind, loop=loop)
    assert (result.outcome.status, result.outcome.time) == ("stopped", 0.2)
    assert times_and_values(result, "one") == ([0.0, 0.1, 0.2],) * 2


@pytest.mark.parametrize("order", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("ends", [{"one": 0.3, "two": 9.0}, {"one": 9.0, "two": 0.3}, {"one": 0.3, "two": 0.3}])
@pytest.mark.parametrize("loop", slow_but_first(["compiled", "plain"]))
def test_a_complete_last_step_has_the_values_of_all_components(simulated, order, ends, loop):
    result = simulated(ends, order=order, loop=loop)
    assert (result.outcome.status, result.outcome.time) == ("stopped", pytest.approx(0.3))
    for name in ends:
        times, values = times_and_values(result, name)
        assert (len(times), times) == (4, pytest.approx(values))


@pytest.mark.parametrize("order", slow_but_first(["gauss_seidel", "jacobi"]))
def test_an_end_within_a_step_of_several_leaves_that_step_out(simulated, order):
    """Others may have no values at 0.25 s; the outcome has that time."""
    result = simulated({"one": 9.0, "two": 0.25, "three": 9.0}, order=order)
    assert (result.outcome.status, result.outcome.time) == ("stopped", 0.25)
    for name in ("one", "two", "three"):
        assert times_and_values(result, name) == ([0.0, 0.1, 0.2],) * 2


def test_an_isolated_fmu_ends_the_run_as_well(simulated):
    result = simulated({"one": 9.0, "two": 0.3}, flags='canBeInstantiatedOnlyOncePerProcess="true"', isolated=True)
    assert (result.outcome.status, result.outcome.component) == ("stopped", "two")
    for name in ("one", "two"):
        assert times_and_values(result, name) == (pytest.approx([0.0, 0.1, 0.2, 0.3]),) * 2


def test_an_end_at_the_start_of_a_step_adds_no_sample(simulated):
    result = simulated({"one": 0.25}, h=0.125)
    assert (result.outcome.time, times_and_values(result, "one")) == (0.25, ([0.0, 0.125, 0.25],) * 2)


def test_simulate_reports_the_end_with_exit_code_0(simulated, runner, tmp_path):
    simulated({"one": 0.25})
    result = runner("simulate", str(tmp_path / "system.toml"), "--set", "one.end=0.25", "-o", str(tmp_path))
    assert (result.exit_code, result.stderr) == (0, "")
    assert_names(result.stdout, "stopped", "one ended the run", "0.25 s")
