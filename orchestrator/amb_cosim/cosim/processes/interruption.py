"""Ctrl-C and SIGTERM: both interrupt the command line, and a run defers them to a safe moment."""

from __future__ import annotations

import _thread
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)

_received: list[int] = []  # numbers of the signals since `interruptible` began


class Interruption:
    """Whether a signal has been received."""

    def __init__(self) -> None:
        self.received = False

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal was received."""
        if self.received:
            raise KeyboardInterrupt


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGTERM raise KeyboardInterrupt within the block, as Ctrl-C does; repeat the interrupt if Python drops it.

    Python drops exceptions that are raised in a finaliser, or in a function that C code calls.
    """
    _received.clear()
    before = _handled() if _in_main_thread() else {}
    report = sys.unraisablehook
    ended = threading.Event()

    def reraise(unraisable: Any) -> None:
        if not isinstance(unraisable.exc_value, KeyboardInterrupt):
            report(unraisable)
            return
        started = threading.Event()
        threading.Thread(target=_interrupt_later, args=(started, ended), daemon=True).start()
        started.set()

    sys.unraisablehook = reraise
    try:
        for number in before:
            signal.signal(number, _interrupt)
        yield
        if _received:
            raise KeyboardInterrupt
    finally:
        sys.unraisablehook = report
        ended.set()
        _restore(before)


@contextmanager
def deferred() -> Iterator[Interruption]:
    """Defer the first interruption; the caller checks for it, and a second one interrupts at once.

    An exception at an arbitrary moment could leave a Python FMU half-way through a call and crash the process.
    """
    interruption = Interruption()
    before = {number: handler for number, handler in _handled().items() if callable(handler)}

    def handle(number: int, _: Any) -> None:
        interruption.received = True
        if before[number] is _interrupt:
            _received.append(number)
        _restore(before)

    if not _in_main_thread():
        before = {}
    interruption.received = bool(_received) and _interrupt in before.values()
    try:
        for number in before:
            signal.signal(number, handle)
        yield interruption
    finally:
        _restore(before)


@contextmanager
def undivided() -> Iterator[None]:
    """Raise KeyboardInterrupt for a signal only after the block is finished; a second signal interrupts at once."""
    with deferred() as interruption:
        before = interruption.received
        yield
    if not before:
        interruption.check()


def was_interrupted() -> bool:
    """Return whether a signal has been received since `interruptible` began."""
    return bool(_received)


def was_terminated() -> bool:
    """Return whether the first signal since `interruptible` began was SIGTERM."""
    return _received[:1] == [signal.SIGTERM]


def _interrupt(number: int, _: Any) -> None:
    _received.append(number)
    raise KeyboardInterrupt


def _handled() -> dict[int, Any]:
    """Return the handlers of the signals that are not ignored."""
    handlers = {int(number): signal.getsignal(number) for number in SIGNALS}
    return {number: handler for number, handler in handlers.items() if handler not in (None, signal.SIG_IGN)}


def _restore(handlers: dict[int, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)


def _interrupt_later(started: threading.Event, ended: threading.Event) -> None:
    """Interrupt the main thread soon after `started` is set; in the hook that sets it, an interrupt would be lost."""
    started.wait()
    if not ended.wait(0.01):
        _thread.interrupt_main()


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
