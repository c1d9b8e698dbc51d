"""pytest plugin that ends a test after `--test-seconds` of processor time and counts it as skipped.

Kernels that are not compiled are a hundred times slower. What a test would have found is found where they are compiled;
here it matters where it passes, and most of that it does at once.
"""

from __future__ import annotations

import signal
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from types import FrameType

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--test-seconds", type=float, default=0.0, help="longest processor time of a test")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup(item: pytest.Item) -> Generator[None, object, object]:
    with _limit(item):
        return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, object, object]:
    with _limit(item):
        return (yield)


@contextmanager
def _limit(item: pytest.Item) -> Iterator[None]:
    def end(_: int, frame: FrameType | None) -> None:
        if frame is None or "site-packages" in frame.f_code.co_filename:
            signal.setitimer(signal.ITIMER_PROF, 0.01)  # whoever it is may hold a lock
        else:
            pytest.skip("takes long where kernels are not compiled")

    before = signal.signal(signal.SIGPROF, end)
    signal.setitimer(signal.ITIMER_PROF, item.config.getoption("--test-seconds"))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
