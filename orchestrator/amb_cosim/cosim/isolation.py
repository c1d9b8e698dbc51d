"""Runs FMUs in a process of their own: a crash or a hang of theirs is an error here, and no end of this process.

It is no sandbox: the FMUs may do there what the user may.
"""

from __future__ import annotations

import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from amb_cosim.cosim.choices import Coupling, Loop
from amb_cosim.cosim.errors import ProcessFailed
from amb_cosim.cosim.interruption import deferred

if TYPE_CHECKING:
    from amb_cosim.cosim.experiment import Plan
    from amb_cosim.cosim.simulation import Assembly, Recording

LONGEST_SILENCE = 300.0  # s without a step, after which the process is ended
POLL_TIME = 0.1  # s between two looks at whether a signal has come

PROGRESS, RECORDING, ERROR, END = range(4)  # kinds of messages

Messages = queue.SimpleQueue[tuple[Any, ...]]


def run_isolated(
    assembly: Assembly,
    plan: Plan,
    progress: Callable[[int, int], None] | None,
    loop: Loop,
    coupling: Coupling | None,
) -> Recording:
    """Run a plan in a process of its own; see `cosim.simulation.run_plan` for arguments, result and errors.

    An interruption ends the run there at a safe moment, and a second one the process.
    """
    with deferred() as interruption, _process((assembly, plan, loop, coupling)) as process:
        messages = _messages(process)
        told, latest = False, time.monotonic()
        while True:
            if interruption.came and not told:
                process.terminate()
                told = True
            try:
                kind, *content = messages.get(timeout=POLL_TIME)
            except queue.Empty:
                if time.monotonic() > latest + LONGEST_SILENCE:
                    raise ProcessFailed(
                        f"{_who(assembly)} did not complete a step within {LONGEST_SILENCE:g} s, and the process was "
                        "ended; nothing was recorded (--no-isolated waits for ever)"
                    ) from None
                continue
            latest = time.monotonic()
            if kind == RECORDING:
                recording: Recording = content[0]
                return recording
            if kind == ERROR:
                raise content[0]
            if kind == END:
                interruption.check()
                raise ProcessFailed(f"the process of {_who(assembly)} {_how(process.wait())}; nothing was recorded")
            if progress is not None:
                progress(*content)


@contextmanager
def _process(given: tuple[Any, ...]) -> Iterator[subprocess.Popen[bytes]]:
    """Start a process that runs what is given; afterwards it is gone in any case."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(str(Path(entry).absolute()) for entry in sys.path)}
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "amb_cosim.cosim.isolated"],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        start_new_session=True,  # Ctrl-C comes to this process alone
    )
    try:
        assert process.stdin is not None
        with suppress(OSError):  # it ends before it reads
            pickle.dump(given, process.stdin)
            process.stdin.flush()
        yield process
    finally:
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            with suppress(OSError):
                stream.close()  # type: ignore[union-attr]


def _messages(process: subprocess.Popen[bytes]) -> Messages:
    """Return what the process says as it says it; the last message is `END`."""
    messages: Messages = queue.SimpleQueue()

    def read(stream: IO[bytes]) -> None:
        with suppress(Exception):  # at its end, and where an FMU wrote among the messages
            while True:
                messages.put(pickle.load(stream))
        messages.put((END,))

    threading.Thread(target=read, args=(process.stdout,), daemon=True).start()
    return messages


def _who(assembly: Assembly) -> str:
    return ", ".join(assembly.from_elsewhere or assembly.fmus)


def _how(code: int) -> str:
    """In words how a process ended."""
    if code >= 0:
        return f"ended with exit code {code}"
    with suppress(ValueError):
        return f"ended with {signal.Signals(-code).name}"
    return f"ended with signal {-code}"
