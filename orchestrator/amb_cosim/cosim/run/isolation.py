"""Runs FMUs in a process of their own: a crash or a hang of theirs is an error here, and no end of this process.

What FMUs start there ends with the run: on Linux all of it, unless the process itself crashes, and then, as on other
systems, what has stayed in its group. It is no sandbox: the FMUs may do there what the user may.
"""

from __future__ import annotations

import logging
import math
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
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

from amb_cosim.cosim.basics.choices import Coupling, Loop
from amb_cosim.cosim.basics.descendants import end_descendants
from amb_cosim.cosim.basics.errors import ProcessFailed
from amb_cosim.cosim.basics.interruption import deferred
from amb_cosim.cosim.run.checkpoint import Checkpoint
from amb_cosim.cosim.run.recording import Recording
from amb_cosim.cosim.run.saving import Saves
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan

log = logging.getLogger(__name__)

LONGEST_SILENCE = 300.0  # s without a step, after which the process is ended
POLL_TIME = 0.1  # s between two looks at whether a signal has come
CLOSE_TIME = 10.0  # s in which the FMUs have to be closed after the run, and what the process had said, to come
NOTICE_DELAY = 0.3  # s after an interruption, until it is said what it waits for

PROGRESS, RECORDING, ERROR, END = range(4)  # kinds of messages

Messages = queue.SimpleQueue[tuple[Any, ...]]


def run_isolated(
    assembly: Assembly,
    plan: Plan,
    progress: Callable[[int, int], None] | None,
    loop: Loop,
    coupling: Coupling | None,
    start: Checkpoint | None,
    saves: Saves,
) -> Recording:
    """Run a plan in a process of its own; see `cosim.simulation.run_plan` for arguments, result and errors.

    An interruption ends the run there at a safe moment, and a second one the process.
    """
    request = assembly, plan, loop, coupling, start, saves
    with deferred() as interruption, own_process("run.isolation_process", request) as process:
        messages = messages_of(process)
        message, tell_at, latest = False, math.inf, time.monotonic()
        while True:
            if interruption.came and not message:
                process.terminate()
                message, tell_at = True, time.monotonic() + NOTICE_DELAY
            if time.monotonic() > tell_at:
                log.warning("waiting for a step of %s to end; a second Ctrl-C ends it at once", _who(assembly))
                tell_at = math.inf
            has_ended = has_process_ended(process)
            try:
                kind, *content = messages.get(timeout=POLL_TIME)
            except queue.Empty:
                if has_ended:
                    end_group(process)  # what it started may keep its output open
                    kind, *content = last_message(messages)
                elif time.monotonic() > latest + LONGEST_SILENCE:
                    raise ProcessFailed(
                        f"{_who(assembly)} did not complete a step within {LONGEST_SILENCE:g} s, and the process was "
                        "ended; nothing was recorded (--no-isolated waits for ever)"
                    ) from None
                else:
                    continue
            latest = time.monotonic()
            if kind == RECORDING:
                return _with_warning(content[0], assembly, _closed(process))
            if kind == ERROR:
                raise content[0]
            if kind == END:
                interruption.check()
                raise ProcessFailed(
                    f"the process of {_who(assembly)} {how_it_ended(process.wait())}; nothing was recorded"
                )
            if progress is not None:
                progress(*content)


def _closed(process: subprocess.Popen[bytes]) -> str:
    """Wait until a process that has sent its record has closed its FMUs; say what went wrong with that, if anything."""
    try:
        code = process.wait(CLOSE_TIME)
    except subprocess.TimeoutExpired:
        return f"had not closed its FMUs after {CLOSE_TIME:g} s, and was ended"
    return how_it_ended(code) if code else ""


def _with_warning(recording: Recording, assembly: Assembly, wrong: str) -> Recording:
    """Return a recording with what went wrong after it, as a warning of the components that may have done it."""
    if not wrong:
        return recording
    text = f"the process of {_who(assembly)} {wrong}, as they were terminated and freed; the record is whole"
    first = next(iter(assembly.from_elsewhere or assembly.fmus))
    said = {**recording.warnings, first: [*recording.warnings.get(first, []), text]}
    return replace(recording, warnings=said)


@contextmanager
def own_process(module: str, given: tuple[Any, ...]) -> Iterator[subprocess.Popen[bytes]]:
    """Start a process that runs a module beside this with what is given; afterwards it is gone in any case."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(str(Path(entry).absolute()) for entry in sys.path)}
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", f"amb_cosim.cosim.{module}"],
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
        end_group(process)
        process.kill()
        process.wait()
        with suppress(OSError):
            process.stdin.close()  # type: ignore[union-attr]


def end_group(process: subprocess.Popen[bytes]) -> None:
    """End a process, which leads a group, with all that it has started."""
    end_descendants(process.pid)
    if sys.platform != "win32":
        with suppress(OSError):
            os.killpg(process.pid, signal.SIGKILL)


def has_process_ended(process: subprocess.Popen[bytes]) -> bool:
    """Return whether a process has ended; its number stays its own, for its group."""
    if sys.platform == "win32":
        return process.poll() is not None
    try:
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def messages_of(process: subprocess.Popen[bytes]) -> Messages:
    """Return what the process says as it says it; the last message is `END`.

    The thread that reads closes what it reads: that may be kept open by what an FMU has started, in a group of its own.
    """
    messages: Messages = queue.SimpleQueue()

    def read(stream: IO[bytes]) -> None:
        with stream, suppress(Exception):  # at its end, and where an FMU wrote among the messages
            while True:
                messages.put(pickle.load(stream))
        messages.put((END,))

    threading.Thread(target=read, args=(process.stdout,), daemon=True).start()
    return messages


def last_message(messages: Messages) -> tuple[Any, ...]:
    """Return the next message of a process that has ended, `END` if none comes."""
    try:
        return messages.get(timeout=CLOSE_TIME)
    except queue.Empty:
        return (END,)


def _who(assembly: Assembly) -> str:
    return ", ".join(assembly.from_elsewhere or assembly.fmus)


def how_it_ended(code: int) -> str:
    """In words how a process ended."""
    if code >= 0:
        return f"ended with exit code {code}"
    with suppress(ValueError):
        return f"ended with {signal.Signals(-code).name}"
    return f"ended with signal {-code}"
