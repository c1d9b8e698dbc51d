"""Who can reach the processes of a sweep, and schedulers that do not answer."""

import os
import signal
import socket
import subprocess
import sys
import threading

import pytest

import amb_cosim
from amb_sweeps import engine
from amb_sweeps.engine import ClusterFailed, connect
from tests.amb_sweeps.conftest import UNTIL, VARY
from tests.support.messages import raises_naming

INTRUDER = """
import os, sys
from distributed import Client, Security

def enter(address, **options):
    try:
        with Client(address, timeout=5, **options) as client:
            return client.submit(os.getuid, pure=False).result(timeout=20)
    except BaseException as error:
        return type(error).__name__

if __name__ == "__main__":
    is_open, secure = sys.argv[1:3]
    own = Security.temporary()
    before = enter(is_open), enter(secure, security=own)  # what is imported later could not be read by another user
    os.setgroups([])
    os.setgid(65534)
    os.setuid(65534)
    plain = secure.replace("tls://", "tcp://")
    print(os.getuid(), enter(is_open), enter(secure), enter(secure, security=own), enter(plain))
"""


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs two users")
def test_another_user_of_the_machine_cannot_enter_a_sweep(cluster, tmp_path):
    script = tmp_path / "intruder.py"
    script.write_text(INTRUDER)
    with connect(jobs=1) as client:
        assert client.submit(os.getuid, pure=False).result(timeout=60) == 0
        command = [sys.executable, str(script), cluster, client.scheduler.address]
        done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=True, cwd=tmp_path)
        assert client.submit(os.getuid, pure=False).result(timeout=60) == 0
    user, entered, *refused = done.stdout.split()
    assert (user, entered) == ("65534", "0"), "the intruder must be able to enter a cluster that is open"
    assert all(word.isidentifier() for word in refused), refused


def test_a_local_cluster_lets_nobody_in_without_its_certificates(monkeypatch):
    monkeypatch.setattr(engine, "ANSWER_TIME", 2)
    with connect(jobs=1) as client:
        addresses = [client.scheduler.address, *client.scheduler_info()["workers"]]
        assert all(address.startswith("tls://") for address in addresses)
        for address in (addresses[0], addresses[0].replace("tls:", "tcp:")):
            with pytest.raises((OSError, TypeError)):
                engine._check_answer(address)


@pytest.fixture
def silent():
    """Address of a server that accepts and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"127.0.0.1:{server.getsockname()[1]}"


@pytest.mark.parametrize(("protocol", "message"), [
    ("tcp", "it did not respond within 1 s"), ("tls", "TLS expects"), ("ucx", ""), ("gopher", "unknown address scheme"),
])  # fmt: skip
def test_a_scheduler_that_never_answers_ends_with_one_message(silent, monkeypatch, protocol, message):
    monkeypatch.setattr(engine, "ANSWER_TIME", 1)
    address = f"{protocol}://{silent}"
    with pytest.raises(ValueError, match=f"no Dask scheduler answers at {address}: {message}"), connect(address):
        pass


def test_a_client_that_hangs_at_its_start_ends_with_one_message(monkeypatch):
    """As Dask's does where the scheduler breaks off in between: its time limit does not hold for that."""
    monkeypatch.setattr(engine, "ANSWER_TIME", 0.05)
    monkeypatch.setattr(engine, "_check_answer", lambda _: None)
    monkeypatch.setattr("distributed.Client", lambda *_, **__: threading.Event().wait(60.0))
    with raises_naming(ValueError, "tcp://there:1", "respond"), connect("tcp://there:1"):
        pass


SCHEDULER = """
import sys, time
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None, memory_limit=0) as cluster:
        print(cluster.scheduler_address, flush=True)
        sys.stdin.read()
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a process is stopped by SIGSTOP")
def test_a_scheduler_that_falls_silent_ends_the_sweep(small, tmp_path, monkeypatch):
    monkeypatch.setattr(engine, "START_TIME", 3)
    (tmp_path / "scheduler.py").write_text(SCHEDULER)
    command = [sys.executable, str(tmp_path / "scheduler.py")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        address = process.stdout.readline().strip()

        def stop(done, total, _):
            if done:
                process.send_signal(signal.SIGSTOP)

        try:
            options = {"until": UNTIL, "scheduler": address, "progress": stop}
            with pytest.raises(ClusterFailed, match="had no worker or did not answer for 3 s"):
                amb_cosim.sweep(small, VARY, output=tmp_path / "out", **options)
        finally:
            process.send_signal(signal.SIGCONT)
            process.stdin.close()
            process.wait(60)
