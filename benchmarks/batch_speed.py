"""Speed of a batch beside the same steps called from C, and of two threads: `python -m benchmarks.batch_speed`.

In C all members do k steps one after the other, again and again, in one call; the batch does the same by `step(k)`.
Two threads take two cores that are free.
"""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Callable
from ctypes import CDLL, byref, c_bool, c_ssize_t, c_void_p, cast
from functools import partial
from pathlib import Path

import amb_cosim

SCENARIO, MEMBERS, STEPS, ROUNDS = "fig5_6", 64, 400, 7
CALLER = """
#include <stddef.h>
typedef void Advance(void *, void *, void *, void *, ptrdiff_t, ptrdiff_t, ptrdiff_t, void *, void *);
void repeat(Advance *advance, ptrdiff_t times, void *programs, void *changes, void *points, void *rests, ptrdiff_t n,
            ptrdiff_t steps, void *pause, void *ends) {
  for (ptrdiff_t i = 0; i < times; i++) advance(programs, changes, points, rests, 0, n, steps, pause, ends);
}
"""


def compiled(folder: Path) -> Callable[..., None]:
    """Return `repeat`, compiled by the machine's compiler."""
    source, library = folder / "caller.c", folder / "caller.so"
    source.write_text(CALLER)
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-o", library, source], check=True)
    result: Callable[..., None] = CDLL(str(library)).repeat
    return result


def time_of(batch: amb_cosim.Batch, work: Callable[[], object], clock: Callable[[], float]) -> float:
    """Return how long work takes (s) on a batch that begins anew."""
    batch.reset()
    began = clock()
    work()
    return clock() - began


def measure() -> None:
    """Print the ratios of the least times of several interleaved rounds."""
    with (
        tempfile.TemporaryDirectory() as folder,
        amb_cosim.Batch(SCENARIO, MEMBERS, threads=1) as item,
        amb_cosim.Batch(SCENARIO, MEMBERS, threads=2) as two,
    ):
        repeat, m, pause = compiled(Path(folder)), item._members, c_bool(False)
        advance = cast(m._advance, c_void_p)  # type: ignore[arg-type]
        points, rests = (c_void_p(array.ctypes.data) for array in (m.points, m.failed))
        for k in (1, 10, 100):
            n = STEPS // k

            def in_c(k: int = k, n: int = n) -> None:
                bounds = c_ssize_t(MEMBERS), c_ssize_t(k)
                repeat(advance, c_ssize_t(n), m._programs, m._changes, points, rests, *bounds, byref(pause), m._ends)

            def by(batch: amb_cosim.Batch, k: int = k, n: int = n) -> None:
                for _ in range(n):
                    batch.step(k)

            rounds = [
                (
                    time_of(item, in_c, time.thread_time),
                    time_of(item, partial(by, item), time.thread_time),
                    time_of(item, partial(by, item), time.perf_counter),
                    time_of(two, partial(by, two), time.perf_counter),
                )
                for _ in range(ROUNDS)
            ]
            c, python, alone, together = (min(times) for times in zip(*rounds, strict=True))
            each = 1e6 * python / STEPS / MEMBERS
            print(
                f"step({k}): {c / python:.3f} of the speed of C, two threads {alone / together:.2f} times one, "
                f"{each:.2f} us a step of a member",
                flush=True,
            )


if __name__ == "__main__":
    measure()
