"""Calls batches of the expander from several threads, as `python threads_of_batches.py SEED CALLS BYPASSED THREADS...`.

Of each number of threads of a batch: three threads of Python step, set, read, save, restore and reset its members at
random, and a fourth closes it in the end. The calls are written down in the order in which the batch makes them; made
once more by one thread they give the same bits. BYPASSED = 1 steps the members without the lock of the batch, for a
sanitizer to see.

`python threads_of_batches.py build` fills the user's cache with loop and FMUs that gcc has compiled with
-fsanitize=thread, the kernels from their C code: all that runs without the interpreter's lock.
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from strange_machine import RUB

import amb_cosim
from amb_cosim.cosim.basics import loop_library
from amb_cosim.scenario.scenario import Scenario
from amb_files.temporary_folders import temporary_folder
from fmi_export.building.native import engines
from fmi_export.building.native.c99.translation import HEADER, to_c
from fmi_export.building.native.sources import texts_of

OPTIONS = ("-shared", "-fPIC", "-O1", "-g1", "-w", "-fvisibility=hidden", "-ffp-contract=off", "-fsanitize=thread")
SHORT = Scenario.load(RUB).changed(end_cycle=9)
MEMBERS, CALLERS = 8, 3
UNBALANCE, PLACES = "rotor_contact.turbine.u", "rotor_contact.*.[xy]"
WRONG = (
    lambda batch: batch.step(0),
    lambda batch: batch.step(2**63),
    lambda batch: batch.set(UNBALANCE, np.nan),
    lambda batch: batch.set(UNBALANCE, [0.0] * (MEMBERS + 1)),
    lambda batch: batch.reset([True]),
    lambda batch: batch.restore({}),
    lambda batch: batch.get("nothing"),
)


class Journal:
    """The calls of a batch in the order in which it makes them: each is noted while the batch is locked for it."""

    def __init__(self, batch: amb_cosim.Batch) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self._batch, self._members, self._local = batch, batch._members, threading.local()
        self._get, self._step, self._save, self._restore = (
            batch.get,
            *map(self._members.__getattribute__, ("step", "save", "restore")),
        )
        self._number: dict[int, int] = {id(self._members.start): 0}
        self._kept = [self._members.start]
        batch.get = self.get  # type: ignore[method-assign]  # what `set` calls while it is locked
        self._members.step, self._members.save, self._members.restore = self.step, self.save, self.restore  # type: ignore[method-assign]

    def set(self, *arguments: Any) -> None:
        self._local.arguments = arguments
        try:
            self._batch.set(*arguments)
        finally:
            self._local.arguments = None

    def get(self, name: str) -> Any:
        values = self._get(name)
        if getattr(self._local, "arguments", None) is not None:
            self.calls.append(("set", *self._local.arguments))
        return values

    def step(self, steps: int) -> None:
        self.calls.append(("step", steps))
        self._step(steps)

    def save(self) -> Any:
        states = self._save()
        self._number[id(states)] = len(self._kept)
        self._kept.append(states)
        self.calls.append(("save",))
        return states

    def restore(self, states: Any, members: list[int]) -> None:
        if id(states) in self._number:
            self.calls.append(("restore", self._number[id(states)], members))
        self._restore(states, members)


def replay(batch: amb_cosim.Batch, calls: list[tuple[Any, ...]]) -> None:
    """Make the calls of a journal, one after the other."""
    kept = [batch._members.start]
    for name, *arguments in calls:
        if name == "set":
            batch.set(*arguments)
        elif name == "step":
            batch.step(*arguments)
        elif name == "save":
            kept.append(batch.save())
        else:
            batch.restore(kept[arguments[0]], [k in arguments[1] for k in range(MEMBERS)])


def state_of(batch: amb_cosim.Batch) -> list[Any]:
    return [batch.time.copy(), batch.failed.copy(), *(batch.get(name).copy() for name in batch.names)]


def call(batch: amb_cosim.Batch, journal: Journal, chance: random.Random, calls: int) -> None:
    """Make random calls; those with wrong arguments are refused."""
    states = [batch._members.start]
    for _ in range(calls):
        kind, mask = chance.random(), [chance.random() < 0.5 for _ in range(MEMBERS)]
        if kind < 0.4:
            batch.step(chance.randint(1, 20))
        elif kind < 0.6:
            values = chance.choice(
                [chance.uniform(0.0, 2e-6), [chance.uniform(0.0, 2e-6) for _ in range(MEMBERS)], 1e6]
            )
            journal.set(UNBALANCE, values, mask)
        elif kind < 0.7:
            states.append(batch.save())
            del states[:-3]
        elif kind < 0.8:
            batch.restore(chance.choice(states), mask)
        elif kind < 0.85:
            batch.reset(mask)
        elif kind < 0.95:
            assert batch.get(chance.choice(batch.names)).shape == batch.time.shape == batch.failed.shape
            batch.reason(chance.randrange(MEMBERS))
        else:
            try:
                chance.choice(WRONG)(batch)
            except ValueError:
                continue
            raise AssertionError("a wrong argument was taken")


def until_closed(batch: amb_cosim.Batch, steps: int) -> None:
    try:
        while True:
            batch.step(steps)
    except ValueError as error:
        if "the batch is closed" not in str(error):
            raise


def together(calls: list[Any]) -> None:
    """Make calls in a thread each; raises AssertionError with what a thread ended with."""
    ends: list[BaseException] = []

    def run(what: Any) -> None:
        try:
            what()
        except BaseException as error:
            ends.append(error)

    threads = [threading.Thread(target=run, args=(what,)) for what in calls]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not ends, repr(ends)


def campaign(seed: int, calls: int, threads: int) -> None:
    with amb_cosim.Batch(SHORT, MEMBERS, threads=threads, variables=[PLACES]) as batch:
        journal, chances = Journal(batch), [random.Random(f"{seed} {k}") for k in range(CALLERS)]
        together([lambda chance=chance: call(batch, journal, chance, calls) for chance in chances])
        result = state_of(batch)
        with amb_cosim.Batch(SHORT, MEMBERS, threads=1, variables=[PLACES]) as other:
            replay(other, journal.calls)
            for values, expected in zip(result, state_of(other), strict=True):
                np.testing.assert_array_equal(values, expected)
        together([lambda: until_closed(batch, 1), lambda: until_closed(batch, 7), batch.close])
    names = [name for name, *_ in journal.calls]
    counts = {name: names.count(name) for name in sorted(set(names))}
    sys.stdout.write(f"{threads} threads: {counts}, {result[1].sum()} members failed\n")


def without_lock(threads: int) -> None:
    """Step members from two threads at once, which the lock of the batch forbids.

    Each makes one call of the compiled loop, of many seconds: the second begins while the first computes, on a loaded
    machine too. The sanitizer ends the process at the first race.
    """
    barrier = threading.Barrier(2)

    def step() -> None:
        barrier.wait()
        batch._members._step((0, MEMBERS), 1000)

    with amb_cosim.Batch(SHORT, MEMBERS, threads=threads, variables=[PLACES]) as batch:
        together([step] * 2)


def compile_sanitized(name: str, sources: Mapping[str, str], platform: str) -> bytes:
    """Compile as `compile_library` does, by gcc with its thread sanitizer."""
    with temporary_folder() as folder:
        for file, text in (sources | texts_of([f"c99/{HEADER}"])).items():
            is_kernel = file.endswith(".ll")
            place = folder / (f"kernels_{Path(file).stem}.c" if is_kernel else file)
            place.write_text(to_c(text) if is_kernel else text, encoding="utf-8")
        files = sorted(str(path) for path in folder.glob("*.c"))
        environment = os.environ | {"LD_PRELOAD": ""}  # gcc itself without the sanitizer
        command = ["gcc", *OPTIONS, "-o", str(folder / "library"), *files, "-lm", "-ldl"]
        subprocess.run(command, check=True, env=environment)
        return (folder / "library").read_bytes()


def build() -> None:
    engines.compile_library = loop_library.compile_library = compile_sanitized
    amb_cosim.Batch(SHORT, 1, threads=1, variables=[PLACES]).close()


if __name__ == "__main__":
    if sys.argv[1] == "build":
        build()
    else:
        seed, calls, is_bypassed, *numbers = map(int, sys.argv[1:])
        for threads in numbers:
            without_lock(threads) if is_bypassed else campaign(seed, calls, threads)
