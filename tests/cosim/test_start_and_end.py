"""Start and stop time that FMUs receive, and the values with which a run begins."""

import re

import numpy as np
import pytest
from informed import SOURCE, description, informed_fmu
from slow import slow_but_first

import amb_cosim
from tests.support.messages import raises_naming


@pytest.fixture(params=slow_but_first([2, 3]), ids="FMI {}".format)
def run(request, fmu_from_c, tmp_path):
    """`run(experiment, components, **options)`: a run of FMUs in series whose outputs are their arguments."""

    def simulate(experiment, components="one", more="", flags=None, slow=None, default="", **options):
        fmu = informed_fmu(fmu_from_c, tmp_path, request.param, default, **(flags or {}))
        every = slow or {}
        parts = [
            f'[[component]]\nname = "{name}"\nfmu = "{fmu}"\nevery = {every.get(name, 1)}\n'
            for name in components.split()
        ]
        path = tmp_path / "system.toml"
        path.write_text("\n".join([more, *parts, f"[experiment]\n{experiment}"]), encoding="utf-8")
        return amb_cosim.simulate(path, **({"isolated": False} | options))

    return simulate


@pytest.mark.parametrize("coupling", ["jacobi", "gauss_seidel", "iterative"])
@pytest.mark.parametrize("options", [{}, {"loop": "plain"}, {"isolated": True}], ids=["compiled", "plain", "isolated"])
def test_outputs_set_at_the_end_of_initialisation_are_the_first_values(run, coupling, options):
    # Reported publicly for FMPy (440) and for FMUs of Simulink and 20-sim, which compute outputs as it ends.
    link = f'coupling = "{coupling}"\n[[connect]]\nfrom = "first"\nto = "second"\nvariables = {{ y = "u" }}\n'
    link += "[parameters.first]\ny0 = 5.0\n"
    steps = 'communication_step = "0.1 s"\nstop_time = "1 s"'
    result = run(steps, "second first", link, **options).dataset
    assert result["first.y"].values[0] == 5.0
    assert set(result["second.used"].values[1:]) == {5.0}
    assert result["second.y"].values[-1] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("default", "tolerance"), [('tolerance="1e-4"', 1e-4), ('stopTime="2"', -1.0), ("", -1.0), ('tolerance="0"', -1.0)]
)
@pytest.mark.parametrize("isolated", [False, True])
def test_an_fmu_integrates_with_the_tolerance_of_its_default_experiment(run, default, tolerance, isolated):
    result = run('communication_step = "0.5 s"\nstop_time = "1 s"', default=default, isolated=isolated)
    assert set(result.dataset["one.tolerance"].values) == {tolerance}


@pytest.mark.parametrize("loop", ["compiled", "plain"])
@pytest.mark.parametrize(("step", "stop", "n"), [(0.6, 1.0, 2), (0.3, 1.0, 4), (0.7, 1.0, 2), (0.1, 0.05, 1)])
def test_a_run_ends_at_its_stop_time_with_a_shorter_step(run, step, stop, n, loop):
    result = run(f'communication_step = "{step} s"\nstop_time = "{stop} s"\ninputs = {{ "one.u" = 1.0 }}', loop=loop)
    data = result.dataset
    times = np.array([*(step * np.arange(n)), stop])
    np.testing.assert_allclose(data["time"], times, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(data["one.reached"], times)
    np.testing.assert_allclose(data["one.y"], times)
    assert result.outcome.time == data["time"].values[-1] == data["one.stop"].values[-1] == stop


@pytest.mark.parametrize("loop", ["compiled", "plain"])
def test_an_fmu_without_outputs_runs_to_the_end(fmu_from_c, tmp_path, loop):
    text = re.sub("<Outputs>.*</Outputs>", "", description(2).replace('causality="output"', 'causality="local"'))
    path = tmp_path / "system.toml"
    system = f'[[component]]\nname = "one"\nfmu = "{fmu_from_c(SOURCE, text, name="sink")}"\n[experiment]\n'
    path.write_text(f'{system}communication_step = "0.1 s"\nstop_time = "1 s"', encoding="utf-8")
    result = amb_cosim.simulate(path, isolated=False, loop=loop)
    assert result.outcome.time == 1.0
    assert (result.dataset.sizes["time"], list(result.dataset.data_vars)) == (11, [])


def test_a_stop_time_between_steps_requires_a_variable_step_size(run):
    rigid = {"canHandleVariableCommunicationStepSize": "false"}
    with raises_naming(ValueError, "stop_time", "1 s", "0.6 s", "one", "canHandleVariableCommunicationStepSize"):
        run('communication_step = "0.6 s"\nstop_time = "1 s"', flags=rigid)
    assert run('communication_step = "0.25 s"\nstop_time = "1 s"', flags=rigid).outcome.time == 1.0


@pytest.mark.parametrize("loop", ["compiled", "plain"])
def test_a_slow_fmu_ends_at_the_stop_time_too(run, loop):
    text = 'communication_step = "0.1 s"\nstop_time = "1 s"\ninputs = { "one.u" = 1.0, "two.u" = 1.0 }'
    data = run(text, "one two", slow={"two": 4}, loop=loop).dataset
    assert data["two.step"].values[-1] == pytest.approx(0.2)
    np.testing.assert_allclose([data[name].values[-1] for name in ("one.y", "two.y", "two.reached")], 1.0)


def test_stop_time_of_an_fmu_is_the_end_of_its_last_step(run):
    steps = 'communication_step = "0.1 s"\nstop_time = "1 s"'
    assert run(steps).dataset["one.stop"].values[0] == 1.0
    rigid = {"canHandleVariableCommunicationStepSize": "false"}
    data = run(steps, "one two", flags=rigid, slow={"two": 4}).dataset
    assert (data["one.stop"].values[0], data["two.stop"].values[0]) == pytest.approx((1.0, 1.2))


@pytest.mark.parametrize("loop", ["compiled", "plain"])
@pytest.mark.parametrize(("start", "stop"), [(20.0, 21.0), (-0.25, 1.0), (-1.0, -0.4), (0.05, 1.25), (-0.1, 0.15)])
def test_a_run_starts_and_is_recorded_from_any_time(run, start, stop, loop):
    text = f'communication_step = "0.1 s"\nstart_time = "{start} s"\nstop_time = "{stop} s"'
    data = run(text, loop=loop).dataset
    assert data["time"].values[[0, -1]] == pytest.approx([start, stop], abs=1e-15)
    assert set(data["one.start"].values) == {start}
    np.testing.assert_allclose(data["one.reached"], data["time"], atol=1e-15)
    assert data["one.stop"].values[0] == data["time"].values[-1]


def test_unrecorded_times_before_0_are_settling(run):
    text = 'communication_step = "0.1 s"\nstart_time = "-1 s"\nstop_time = "1 s"\nrecord.settling = false'
    data = run(text).dataset
    assert (data["time"].values[0], data["one.start"].values[0]) == (0.0, -1.0)
    np.testing.assert_allclose(data["one.reached"], data["time"], atol=1e-15)


def test_changes_and_conditions_count_from_a_later_start(run):
    changes = """
[[experiment.event]]
time = "20.5 s"
set = { "one.u" = 2.0 }
[[experiment.stop]]
variable = "one.y"
above = 0.5
"""
    text = f'communication_step = "0.1 s"\nstart_time = "20 s"\nstop_time = "22 s"{changes}'
    result = run(text)
    assert result.outcome.time == pytest.approx(20.8)
    np.testing.assert_allclose(
        result.dataset["one.y"], 2.0 * np.maximum(0.0, result.dataset["time"] - 20.5), atol=1e-12
    )
    with raises_naming(ValueError, "time of event", "5 s", "20 s"):
        run(text.replace("20.5", "5"))


def test_a_profile_is_exact_at_a_shorter_last_step(run):
    profile = '\n[[experiment.profile]]\nvariable = "one.u"\npoints = [["0 s", 0.0], ["1.8 s", 3.6]]'
    for loop in ("compiled", "plain"):
        data = run(f'communication_step = "0.6 s"\nstop_time = "1 s"{profile}', loop=loop).dataset
        np.testing.assert_allclose(data["one.u"], [0.0, 1.2, 2.0])


def test_an_end_before_the_start_is_refused(run):
    with raises_naming(ValueError, "stop_time", "1 s", "20 s"):
        run('communication_step = "0.1 s"\nstart_time = "20 s"\nstop_time = "1 s"')


def test_a_state_after_a_shortened_step_cannot_be_continued(run):
    text = 'communication_step = "0.6 s"\nstop_time = "1 s"\ninputs = { "one.u" = 1.0 }'
    whole = run(text, save_at=["0.6 s", "1 s"])
    assert whole.dataset["one.stop"].values[0] == -1.0  # a saved state may be continued
    longer = run(text.replace("1 s", "2 s"), start=whole.checkpoint("0.6 s"))
    np.testing.assert_allclose(longer.dataset["one.y"], longer.dataset["time"])
    with raises_naming(ValueError, "checkpoint", "end"):
        run(text.replace("1 s", "2 s"), start=whole.checkpoint("1 s"))
