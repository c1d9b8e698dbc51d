"""FMUs that return undefined statuses, leave processes behind, or crash when they are terminated."""

import signal

import numpy as np
import pytest
from command_line import run_command
from fmu_systems import system_text, write_system
from slow import slow_but_first
from waiting import LONGEST, wait_until

import amb_cosim
from amb_cosim.cosim.errors import StartFailed
from amb_cosim.cosim.record.warnings import warnings_of
from amb_cosim.cosim.run import isolation
from tests.support.messages import assert_names


@pytest.fixture(params=slow_but_first([2, 3]), ids="FMI {}".format)
def system(request, hostile, tmp_path):
    """Path of a system of the hostile FMU alone, in either version of FMI."""
    return write_system(tmp_path, {"one": hostile.fmu(request.param)})


@pytest.fixture
def run(system, hostile):
    """`run(deed, function, **options)`: the result if the FMU does that at its sixth step, or at the end."""

    def simulate(deed, function="DoStep", **options):
        hostile.will(deed, 5 if function == "DoStep" else 0, function)
        return amb_cosim.simulate(system, **options)

    return simulate


@pytest.mark.parametrize("loop", ["compiled", "plain"])
@pytest.mark.parametrize(
    ("deed", "facts"),
    [
        ("minus_one", ("-1", "FMI")),
        ("ninety_nine", ("99", "FMI")),
        ("discard", ("Discard", "lastSuccessfulTime", "0.00525 s")),
        ("fatal", ("DoStep answered Fatal",)),  # it aborts at any further call, since FMI allows none
    ],
)
def test_a_bad_status_ends_the_run_with_the_reason(run, deed, facts, loop):
    result = run(deed, loop=loop)
    assert (result.outcome.status, result.outcome.time) == ("failed", 0.005)
    assert_names(result.outcome.reason.replace("fmi2", "").replace("fmi3", ""), *facts)
    assert not warnings_of(result.dataset)


@pytest.mark.parametrize(
    ("deed", "sentence"),
    [
        ("latin", "Temp\ufffdrature trop \ufffdlev\ufffde"),  # no UTF-8
        ("complain", "no table, defaults apply"),  # an error that a successful step logs
    ],
)
def test_a_message_of_a_successful_step_is_a_warning(run, deed, sentence):
    result = run(deed)
    assert result.outcome.status == "completed"
    assert {w.sentence for w in warnings_of(result.dataset)} == {sentence}


def test_the_command_prints_what_a_foreign_fmu_logs(system, hostile, tmp_path):
    """With the name of the component, as `run` prints the warnings of a scenario."""
    hostile.will("complain", 5, "DoStep")
    done = run_command("simulate", system, "-o", tmp_path / "out", cwd=tmp_path)
    (line,) = [line for line in done.stdout.splitlines() if "no table, defaults apply" in line]
    assert line.startswith("warning: ")
    assert "one" in line.partition("apply")[2]


def test_a_nan_fails_the_run_and_keeps_its_record(run):
    result = run("nan")
    assert_names(result.outcome.failure, "one.y", "nan", "0.006 s")
    assert result.dataset.sizes["time"] == 11


def test_an_infinite_value_is_a_warning_with_name_and_time(run):
    result = run("inf")
    assert result.outcome.status == "completed"
    (warned,) = warnings_of(result.dataset)
    assert_names(warned.sentence, "one.y", "inf", "0.006 s")
    assert not warnings_of(run("nothing").dataset)


@pytest.mark.parametrize("loop", ["compiled", "plain"])
def test_nan_between_records_is_detected_on_connected_outputs(hostile, tmp_path, loop):
    """The sixth of ten steps gives no number, once; only each tenth is recorded, and the sum has it no more."""
    connect = '[[connect]]\nfrom = "one"\nto = "two"\nvariables = { "y" = "u" }\n'
    text = system_text(dict.fromkeys(("one", "two"), hostile.fmu(2)), more=connect)
    path = tmp_path / "system.toml"
    path.write_text(text.replace('["*"]', '["two.y"]\nrecord.every = 10'), encoding="utf-8")
    for deed in ("nan", "inf", "nothing"):
        hostile.will(deed, 10, "DoStep")
        result = amb_cosim.simulate(path, loop=loop)
        assert result.dataset["two.y"].values.tolist() == pytest.approx([0.0, 0.01])
        if deed == "nan":
            assert result.outcome.component == "one"
            assert_names(result.outcome.failure, "one.y", "nan", "0.006 s")
        else:
            sentences = [warned.sentence for warned in warnings_of(result.dataset)]
            assert result.outcome.status == "completed"
            assert len(sentences) == (deed == "inf")
            for sentence in sentences:
                assert_names(sentence, "one.y", "inf", "0.006 s")


@pytest.mark.parametrize("deed", ["fork", "fork_away", "daemon"])
def test_a_process_started_by_an_fmu_ends_with_the_run(run, hostile, monkeypatch, deed):
    monkeypatch.setattr(isolation, "CLOSE_TIME", 2.0)
    result = run(deed)
    assert (result.outcome.status, result.dataset.sizes["time"]) == ("completed", 11)
    wait_until(lambda: not hostile.processes())


@pytest.mark.parametrize("function", ["EnterInitializationMode", "ExitInitializationMode"])
def test_error_names_an_fmu_that_returns_fatal_at_its_start(run, function):
    with pytest.raises(StartFailed, match=rf"^one: fmi\d{function} answered Fatal"):
        run("fatal", function)


@pytest.mark.parametrize("function", ["Terminate", "FreeInstance"])
def test_a_crash_at_termination_keeps_the_record(run, function):
    result = run("segv", function)
    assert result.outcome.status == "completed"
    np.testing.assert_allclose(result.dataset["one.y"][-1], 0.01)
    (warned,) = warnings_of(result.dataset)
    assert_names(warned.sentence, "process of one", "SIGSEGV", "terminated", "record is complete")


def test_ctrl_c_reports_the_step_it_waits_for_and_ends_all_processes(start, system, hostile):
    hostile.will("hang", 5, "DoStep")
    process = start("simulate", system, "-o", "out")
    wait_until(hostile.hangs)
    process.send_signal(signal.SIGINT)
    line = next(line for line in process.stderr if "waiting" in line)
    assert_names(line, "one to complete its step", "Ctrl-C")
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=LONGEST)
    assert process.returncode == 130
    assert not hostile.processes()
