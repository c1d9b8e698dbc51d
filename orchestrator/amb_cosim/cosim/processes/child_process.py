"""Processes that this package starts for FMUs; each leads a process group and a session of its own."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from amb_cosim.cosim.processes.descendants import end_descendants
from amb_cosim.cosim.processes.memory import physical_memory
from fmi_export.compiling import import_path

SHARE_OF_MEMORY = 0.75  # of this machine's memory that a process of FMUs may use


@contextmanager
def child_process(module: str, arguments: tuple[Any, ...]) -> Iterator[subprocess.Popen[bytes]]:
    """Run a module of `cosim` in a process that reads the pickled arguments; end the process when the block ends."""
    environment = os.environ | {"PYTHONPATH": import_path()}
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", f"amb_cosim.cosim.{module}"],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C reaches only the parent
    )
    try:
        assert process.stdin is not None
        with suppress(OSError):  # it ended before it read them
            pickle.dump(arguments, process.stdin)
            process.stdin.flush()
        yield process
    finally:
        end_group(process)
        process.kill()
        process.wait()
        with suppress(OSError):
            process.stdin.close()  # type: ignore[union-attr]


def end_group(process: subprocess.Popen[bytes]) -> None:
    """End a process that leads a process group, together with all its descendants."""
    end_descendants(process.pid)
    if sys.platform != "win32":
        with suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)


def how_it_ended(code: int) -> str:
    """Return a description of how a process ended."""
    if code >= 0:
        return f"ended with exit code {code}"
    with suppress(ValueError):
        return f"ended with {signal.Signals(-code).name}"
    return f"ended with signal {-code}"


def limit_memory() -> float:
    """Limit this process to a share of the memory, if the system supports it; return the limit in bytes."""
    if sys.platform == "win32":
        return float("inf")
    import resource

    limit = int(SHARE_OF_MEMORY * physical_memory())
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _, highest = resource.getrlimit(resource.RLIMIT_AS)
    limit = limit if highest == resource.RLIM_INFINITY else min(limit, highest)
    resource.setrlimit(resource.RLIMIT_AS, (limit, highest))
    return limit
