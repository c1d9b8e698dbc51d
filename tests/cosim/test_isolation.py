"""FMUs in a separate process: the same data, and a crash or a hang ends with one message and exit code 1."""

import os
import pickle
import signal

import numpy as np
import pytest
from fmu_systems import write_system
from waiting import LONGEST, children, is_running, of_process, wait_for_work, wait_until

import amb_cosim
from amb_cosim.cosim.errors import FmuError, ProcessFailed, StartFailed
from amb_cosim.cosim.run import execution as simulation
from amb_cosim.cosim.run import isolation
from tests.support.messages import assert_names, raises_naming


@pytest.fixture
def system(hostile, tmp_path):
    """`system(deed, end)`: path of a system whose FMU does that after 5 ms."""

    def write(deed="nothing", end="10 ms"):
        hostile.will(deed, 5, "DoStep")
        return write_system(tmp_path, {"one": hostile.fmu(2)}, end=end)

    return write


def test_isolated_run_has_the_data_of_a_run_in_this_process():
    both = [amb_cosim.run("fig4_9", until=0.02, isolated=isolated) for isolated in (True, False)]
    ours, others = (result.dataset for result in both)
    assert ours.equals(others)
    same = {name for name in ours.attrs if ours.attrs[name] == others.attrs[name]}
    assert set(ours.attrs) - same <= {"wall_s"}
    assert both[0].outcome == both[1].outcome


@pytest.mark.parametrize(("deed", "facts"), [
    ("segv", ("process of one", "SIGSEGV")),
    ("leave", ("process of one", "exit code 0")),
])  # fmt: skip
def test_a_crash_ends_with_one_message_and_exit_code_1(runner, system, tmp_path, deed, facts):
    result = runner("simulate", str(system(deed)), "-o", "out")
    assert result.exit_code == 1
    assert_names(result.stderr.splitlines()[-1], "amb-cosim", *facts)
    assert not (tmp_path / "out").exists()


def test_a_hang_is_ended(system, monkeypatch):
    monkeypatch.setattr(isolation, "LONGEST_SILENCE", 2.0)
    with raises_naming(ProcessFailed, "one", "2 s"):
        amb_cosim.simulate(system("hang"))


def test_an_allocation_beyond_the_limit_of_an_fmu_fails(system):
    assert amb_cosim.simulate(system("eat")).outcome.status == "failed"


def test_output_printed_by_an_fmu_is_not_taken_for_a_reply(system, capfd):
    assert amb_cosim.simulate(system("print")).outcome.status == "completed"
    printed = capfd.readouterr()
    assert (printed.out, "a word among the answers" in printed.err) == ("", True)


def test_errors_and_progress_reach_the_calling_process(system):
    steps = []
    result = amb_cosim.simulate(system(), progress=lambda done, total: steps.append((done, total)))
    assert steps[-1] == (10, 10)
    np.testing.assert_allclose(result.dataset["one.y"][-1], 0.01)
    with raises_naming(StartFailed, "rotor_contact", "rb1.offset_x", "0.00075 m"):
        amb_cosim.run("fig4_9", set={"rotor_contact.rb1.offset_x": 0.75e-3}, isolated=True)


def test_an_error_of_an_fmu_is_the_same_in_another_process():
    error = FmuError("fmi2DoStep", "Error", ["it is late", "it is dark"], 0.25)
    other = pickle.loads(pickle.dumps(error))
    assert (str(other), other.status, other.log, other.end) == (str(error), error.status, error.log, 0.25)


@pytest.mark.parametrize(("given", "foreign", "expected"), [
    (None, True, True), (None, False, False), (False, True, False), (True, False, True),
])  # fmt: skip
def test_foreign_fmus_are_isolated_by_default(system, monkeypatch, given, foreign, expected):
    class Chosen(Exception):
        pass

    def chosen(*_):
        raise Chosen

    monkeypatch.setattr(simulation, "run_isolated", chosen)
    run = amb_cosim.simulate if foreign else amb_cosim.run
    options = {} if foreign else {"until": 0.001}
    if expected:
        with pytest.raises(Chosen):
            run(system() if foreign else "fig4_9", isolated=given, **options)
    else:
        run(system() if foreign else "fig4_9", isolated=given, **options)


def hosts(process):
    """The children of a process that have loaded the FMU."""
    return [child for child in children(process.pid) if "hostile" in of_process(child, "maps")]


@pytest.mark.parametrize(("number", "code", "is_stopped"), [
    (signal.SIGINT, 130, False), (signal.SIGTERM, 143, False),
    (signal.SIGKILL, -signal.SIGKILL, False), (signal.SIGKILL, -signal.SIGKILL, True),
])  # fmt: skip
def test_a_signal_ends_the_process_of_the_fmus_too(start, system, tmp_path, number, code, is_stopped):
    process = start("simulate", system(end="1e5 s"), "-o", "out")
    wait_until(lambda: hosts(process))
    (child,) = hosts(process)
    wait_for_work(child, 0.3)
    if is_stopped:
        os.kill(child, signal.SIGSTOP)
    os.kill(process.pid, number)
    _, errors = process.communicate(timeout=LONGEST)
    assert process.returncode == code
    if number != signal.SIGKILL:
        assert errors.splitlines()[-1].startswith("amb-cosim: interrupted at t = ")
        assert (tmp_path / "out" / "result.nc").is_file()
    wait_until(lambda: not is_running(child))


@pytest.mark.parametrize("loading", ["amb_cosim.simulate(path)", "amb_cosim.verify(fmu)"])
def test_the_first_loading_of_an_fmu_from_elsewhere_warns_not_a_check(run_python, system, loading):
    def warnings(path: str, loading: str) -> list:
        import os
        import subprocess
        import sys

        os.environ["XDG_CACHE_HOME"] = os.environ["TMPDIR"]
        check = "assembly.assemble(amb_cosim.load_system(path))"
        begin = "import amb_cosim\nfrom amb_cosim.cosim.system import assembly\n"
        begin += f"path = {path!r}\nfmu = amb_cosim.load_system(path).components[0].fmu\ntry:\n    "
        end = "\nexcept ValueError: pass"  # it has no reference results
        return [
            subprocess.run([sys.executable, "-c", begin + deed + end], stderr=subprocess.PIPE, text=True).stderr
            for deed in (check, check, loading, loading)
        ]

    checked, checked_again, first, second = run_python(warnings, path=str(system()), loading=loading)
    assert checked == checked_again == second == ""
    assert_names(first, "Hostile.fmu", "first time", "permissions")


def test_a_script_without_a_main_guard_runs_foreign_fmus(run_python, system):
    program = f"import amb_cosim\nresult = str(amb_cosim.simulate({str(system())!r}).outcome)"
    assert run_python(program) == "completed at t = 0.01 s"
