"""Runs FMUs in a separate process; if an FMU crashes or hangs, this process raises an error and continues.

A run ends the processes that its FMUs started. On Linux, it ends all of them; on other systems, and after a crash of
the separate process, it ends only those that stayed in the group of the separate process. This is not a sandbox: the
FMUs have the user's permissions.
"""

from __future__ import annotations

import logging
import math
import os
import pickle
import queue
import subprocess
import sys
import threading
import time
from contextlib import suppress
from dataclasses import replace
from typing import IO, Any

from amb_cosim.cosim.errors import ProcessFailed
from amb_cosim.cosim.processes.child_process import child_process, end_group, how_it_ended
from amb_cosim.cosim.processes.interruption import deferred
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.run.recording import Recording
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import Plan

log = logging.getLogger(__name__)

LONGEST_SILENCE = 300.0  # s without a step, after which the process is ended
POLL_TIME = 0.1  # s between checks for a signal
CLOSE_TIME = 10.0  # s within which the FMUs must be closed after the run, and the last messages arrive
NOTICE_DELAY = 0.3  # s from an interruption to the notice of what it waits for

PROGRESS, RECORDING, ERROR, END = range(4)  # kinds of messages

Messages = queue.SimpleQueue[tuple[Any, ...]]


def run_isolated(plan: Plan, options: RunOptions) -> Recording:
    """Run a plan in a separate process; see `execute_plan` for result and errors.

    An interruption ends the run at a safe moment; a second one ends the process.
    """
    assembly, request = plan.assembly, (plan, replace(options, instances=None, progress=None))
    with deferred() as interruption, child_process("run.isolation_process", request) as process:
        messages = messages_of(process)
        is_ending, notice_at, latest = False, math.inf, time.monotonic()
        while True:
            if interruption.received and not is_ending:
                process.terminate()
                is_ending, notice_at = True, time.monotonic() + NOTICE_DELAY
            if time.monotonic() > notice_at:
                log.warning(
                    "waiting for %s to complete its step; press Ctrl-C again to end it at once", _names(assembly)
                )
                notice_at = math.inf
            if (received := next_message(process, messages)) is None:
                if time.monotonic() > latest + LONGEST_SILENCE:
                    raise ProcessFailed(
                        f"{_names(assembly)} did not complete a step within {LONGEST_SILENCE:g} s, and the process was "
                        f"ended; nothing was recorded (isolated = False sets no limit)"
                    )
                continue
            kind, *content = received
            latest = time.monotonic()
            if kind == RECORDING:
                return _with_warning(content[0], assembly, _wait_until_closed(process))
            if kind == ERROR:
                raise content[0]
            if kind == END:
                interruption.check()
                raise ProcessFailed(
                    f"the process of {_names(assembly)} {how_it_ended(process.wait())}; nothing was recorded"
                )
            if options.progress is not None:
                options.progress(*content)


def _wait_until_closed(process: subprocess.Popen[bytes]) -> str:
    """Wait until a process that has sent its record has closed its FMUs; return the error, if there is one."""
    try:
        code = process.wait(CLOSE_TIME)
    except subprocess.TimeoutExpired:
        return f"had not closed its FMUs after {CLOSE_TIME:g} s, and was ended"
    return how_it_ended(code) if code else ""


def _with_warning(recording: Recording, assembly: Assembly, fault: str) -> Recording:
    """Return a recording with a warning about a later error; it names the components that may have caused the error."""
    if not fault:
        return recording
    text = (
        f"the process of {_names(assembly)} {fault} while the FMUs were being terminated and freed; the record is "
        f"complete"
    )
    first = next(iter(assembly.from_elsewhere or assembly.fmus))
    warnings = {**recording.warnings, first: [*recording.warnings.get(first, []), text]}
    return replace(recording, warnings=warnings)


def messages_of(process: subprocess.Popen[bytes]) -> Messages:
    """Return a queue that receives the messages of a process as they arrive; the last message is `END`.

    The reading thread closes the pipe; a process that an FMU started in a group of its own may keep the pipe open.
    """
    messages: Messages = queue.SimpleQueue()

    def read(stream: IO[bytes]) -> None:
        with stream, suppress(Exception):  # it has ended, or an FMU wrote among the messages
            while True:
                messages.put(pickle.load(stream))
        messages.put((END,))

    threading.Thread(target=read, args=(process.stdout,), daemon=True).start()
    return messages


def next_message(process: subprocess.Popen[bytes], messages: Messages) -> tuple[Any, ...] | None:
    """Return the next message of a process, `END` if it ended without one, or None if none came within `POLL_TIME`."""
    has_ended = _has_ended(process)
    try:
        return messages.get(timeout=POLL_TIME)
    except queue.Empty:
        if not has_ended:
            return None
    end_group(process)  # what it started may keep its output open
    try:
        return messages.get(timeout=CLOSE_TIME)
    except queue.Empty:
        return (END,)


def _has_ended(process: subprocess.Popen[bytes]) -> bool:
    """Return whether a process has ended, but do not release its ID, which is also the ID of its group."""
    if sys.platform == "win32":
        return process.poll() is not None
    try:
        return os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def _names(assembly: Assembly) -> str:
    return ", ".join(assembly.from_elsewhere or assembly.fmus)
