"""Processes that import the script of the process that starts them, and end with it."""

import os
import signal
import subprocess
import sys
import zipfile

import pytest
from waiting import is_running, of_process, wait_until

from amb_cosim.cosim.processes.descendants import descendants
from tests.support.messages import assert_names

CHECK = "from amb_analysis.studies.processes import check_script; check_script()"
SWEEP = """
import sys, time

if __name__ == "__main__":
    from amb_sweeps.engine import local_cluster

    with local_cluster(1) as cluster:
        print(*(nanny.pid for nanny in cluster.workers.values()), flush=True)
        time.sleep(600)
"""
STUDY = """
import os, time
from amb_analysis.studies.processes import simulate_in_processes

def wait(_):
    print(os.getpid(), flush=True)
    time.sleep(600)

if __name__ == "__main__":
    simulate_in_processes(wait, [0], print)
"""


def checked(*arguments, cwd, text=""):
    command = [sys.executable, *arguments]
    return subprocess.run(command, input=text, capture_output=True, text=True, cwd=cwd, check=False)


@pytest.mark.parametrize("first", ["", "import os; os.chdir('/')\n"])
@pytest.mark.parametrize("options", [("-c", CHECK), ("script.py",), ("-m", "script"), ("program.zip",)], ids=str)
def test_processes_can_import_a_script_that_is_a_file(options, first, tmp_path):
    (tmp_path / "script.py").write_text(first + CHECK, encoding="utf-8")
    with zipfile.ZipFile(tmp_path / "program.zip", "w") as program:
        program.writestr("__main__.py", first + CHECK)
    done = checked(*options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("options", "named"),
    [(("-",), "standard input"), ((), "standard input"), (("removed.py",), "removed.py")],
    ids=["python -", "python <", "removed"],
)
def test_a_script_that_is_no_file_is_the_cause_named(options, named, tmp_path):
    (tmp_path / "removed.py").write_text(f"import os; os.remove('removed.py')\n{CHECK}", encoding="utf-8")
    done = checked(*options, cwd=tmp_path, text=CHECK)
    assert_names(done.stderr.splitlines()[-1], "ValueError", named, "import", "file")


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="a stopped process continues by a signal of Linux")
@pytest.mark.parametrize("script", [SWEEP, STUDY], ids=["sweep", "study"])
def test_a_stopped_process_ends_with_its_killed_parent(script, tmp_path):
    (tmp_path / "script.py").write_text(script, encoding="utf-8")
    command = [sys.executable, "script.py"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=tmp_path) as parent:
        assert parent.stdout is not None
        worker = int(parent.stdout.readline())
        os.kill(worker, signal.SIGSTOP)
        parent.kill()
    wait_until(lambda: not is_running(worker))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="a stopped process continues by a signal of Linux")
def test_a_process_stopped_as_it_starts_ends_with_its_parent(tmp_path):
    """It is stopped while it imports Dask, which then cannot end it; no shell is there to continue it."""
    (tmp_path / "script.py").write_text(f"import amb_cosim.start\n{SWEEP}", encoding="utf-8")  # as the command does
    command = [sys.executable, "script.py"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, cwd=tmp_path, start_new_session=True) as parent:
        wait_until(lambda: any("numpy" in of_process(child, "maps") for child in spawned(parent.pid)))
        workers = spawned(parent.pid)
        for worker in workers:
            os.kill(worker, signal.SIGSTOP)
        parent.kill()
    wait_until(lambda: not any(map(is_running, workers)))


def spawned(process):
    """Return the processes that multiprocessing has started for another."""
    return [child for child in descendants(process) if "spawn_main" in of_process(child, "cmdline")]
