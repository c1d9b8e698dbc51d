"""Calls an FMU in any order with any values, as `python random_calls.py FOLDER SEED CALLS THREADS SLOWEST JOURNAL`.

The last line that it prints is a count of calls by function and status, in JSON. The process ends with a message if an
instance gives what is not allowed: a number that is not finite with status OK, a step after a fault, a status that is
not one of OK, Warning and Error, a state that it takes and has not saved, a call that takes longer than SLOWEST seconds
of the processor's time. The file JOURNAL holds the last call of each thread, for a process that crashes or hangs.
"""

from __future__ import annotations

import collections
import ctypes
import json
import math
import mmap
import os
import random
import sys
import threading
import time
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from raw import ERROR, OK, WARNING, Library, Slave

STRANGE = (math.nan, math.inf, -math.inf, 0.0, -0.0, 5e-324, -1e-310, 1e-100, 1e100, -1e100, 1.7e308, -1.7e308)
STRANGE_INTEGERS = (0, 1, -1, 2**31 - 1, -(2**31))
H = 250e-6  # s, the usual communication step
LINE = 400  # bytes of the journal for a thread


class Variable:
    """A variable with its range."""

    def __init__(self, element: ElementTree.Element, ranges: dict[str, tuple[str, str]]) -> None:
        kind = element[0]
        self.name = element.get("name", "")
        self.reference = int(element.get("valueReference", ""))
        self.causality = element.get("causality", "local")
        self.type = kind.tag.replace("Enumeration", "Integer")
        low, high = ranges.get(kind.get("declaredType", ""), ("", ""))
        unlimited = 1e12 if self.type == "Real" else 1000
        self.low = float(kind.get("min") or low or -unlimited)
        self.high = float(kind.get("max") or high or unlimited)
        self.start = float({"true": 1, "false": 0}.get(kind.get("start", "0"), kind.get("start", "0")))

    def value(self, chance: random.Random, strange: float) -> float:
        """A value: within the range, of any magnitude, or near the start value; `strange` is the share of others."""
        if self.type == "Boolean":
            return float(chance.randrange(2))
        if chance.random() < strange:
            return float(chance.choice(STRANGE if self.type == "Real" else STRANGE_INTEGERS))
        if self.type == "Integer":
            return float(chance.randint(int(self.low), int(self.high)))
        kind = chance.random()
        if kind < 0.05:
            return chance.choice((self.low, self.high))
        if kind < 0.4 and self.start:
            return self.start * 10 ** chance.uniform(-1, 1)
        if kind < 0.6:
            return chance.uniform(self.low, self.high)
        largest = max(abs(self.low), abs(self.high))
        size = largest * 10 ** chance.uniform(-15, 0)
        return min(max(chance.choice((size, -size)), self.low), self.high)


def variables_of(folder: Path) -> list[Variable]:
    root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    ranges = {}
    for kind in root.iterfind("TypeDefinitions/SimpleType"):
        items = [int(item.get("value", "")) for item in kind.iterfind("Enumeration/Item")]
        if items:
            ranges[kind.get("name", "")] = (str(min(items)), str(max(items)))
        else:
            ranges[kind.get("name", "")] = (kind[0].get("min", ""), kind[0].get("max", ""))
    return [Variable(element, ranges) for element in root.iterfind("ModelVariables/ScalarVariable")]


class Mistake(Exception):
    """An FMU did what is not allowed."""


class Caller:
    """One thread's instances, and its calls."""

    def __init__(self, library: Library, variables: list[Variable], seed: int, journal: Any, slowest: float) -> None:
        self.library, self.variables = library, variables
        self.chance = random.Random(seed)
        self.journal, self.slowest = journal, slowest
        self.instances: list[Slave | None] = [None] * 3
        self.times = [0.0] * 3
        self.strange = [0.0] * 3
        self.faulty = [False] * 3
        self.states: list[c_void_p | None] = [None] * 3
        self.freed: c_void_p | None = None
        self.counts: collections.Counter[str] = collections.Counter()
        outputs = [v.reference for v in variables if v.causality == "output" and v.type == "Real"]
        self.references = (c_uint * len(outputs))(*outputs)
        self.values = (c_double * len(outputs))()
        self.names = [v.name for v in variables if v.causality == "output" and v.type == "Real"]
        self.settable = [v for v in variables if v.causality in ("parameter", "input")]
        self.fault = next(v.reference for v in variables if v.name == "fault_code")

    def run(self, calls: int) -> None:
        try:
            while sum(self.counts.values()) < calls:
                self.once(self.chance.randrange(3))
        finally:
            for k, instance in enumerate(self.instances):
                if instance is not None:
                    self.free(k)

    def call(self, k: int, function: str, *arguments: Any, said: str = "") -> int:
        instance = self.instances[k]
        assert instance is not None
        del instance.log[:]
        number = sum(self.counts.values())
        line = f"call {number}: instance {k}, fmi2{function} {said}"[: LINE - 1]
        self.journal(line)
        begin = time.thread_time()
        status = instance.call(function, *arguments)
        taken = time.thread_time() - begin
        self.counts[f"{function} {status}"] += 1
        if status not in (OK, WARNING, ERROR) and not function.endswith("Status"):
            raise Mistake(f"{line}: status {status}")
        if taken > self.slowest:
            raise Mistake(f"{line}: it took {taken:.2f} s")
        return status

    def once(self, k: int) -> None:
        chance = self.chance
        if self.instances[k] is None:
            self.instances[k] = instance = self.library.instantiate(logging=chance.randrange(2))
            self.times[k], self.faulty[k] = 0.0, False
            self.strange[k] = chance.choice((0.0, 0.0, 0.02))
            if not instance.pointer:
                raise Mistake(f"no instance: {instance.log}")
            self.begin(k)
            return
        kind = chance.random()
        if kind < 0.4:
            self.step(k)
        elif kind < 0.6:
            self.set_some(k, 4)
        elif kind < 0.7:
            self.read(k)
        elif kind < 0.72:
            self.free(k)
        elif kind < 0.76:
            self.restart(k)
        elif kind < 0.98 or not self.strange[k]:
            self.state(k)
        else:
            self.anything(k)

    def restart(self, k: int) -> None:
        self.call(k, "Reset")
        self.times[k], self.faulty[k] = 0.0, False
        self.begin(k)

    def begin(self, k: int) -> None:
        """Most instances are initialised, some with many values."""
        chance = self.chance
        self.set_some(k, chance.choice((0, 0, 3, 10, 60)), of=("parameter", "input"))
        if chance.random() < 0.95:
            self.call(k, "SetupExperiment", 0, c_double(0.0), c_double(0.0), 0, c_double(0.0))
        if chance.random() < 0.97:
            self.call(k, "EnterInitializationMode")
        if chance.random() < 0.3:
            self.set_some(k, 3)
            self.read(k)
        if chance.random() < 0.97:
            self.call(k, "ExitInitializationMode")
        self.read(k)

    def set_some(self, k: int, most: int, of: tuple[str, ...] = ("input",)) -> None:
        chance = self.chance
        allowed = (
            [v for v in self.settable if v.causality in of] if chance.random() > self.strange[k] else self.variables
        )
        for v in chance.sample(allowed, min(chance.randint(0, most), len(allowed))):
            value = v.value(chance, self.strange[k])
            number = c_double(value) if v.type == "Real" else c_int(int(value))
            self.call(
                k, f"Set{v.type}", byref(c_uint(v.reference)), c_size_t(1), byref(number), said=f"{v.name} = {value!r}"
            )

    def step(self, k: int) -> None:
        chance = self.chance
        kind = chance.random()
        h = H if kind < 0.5 else 10 ** chance.uniform(-18, -2) if kind < 0.9 else 10 ** chance.uniform(-2, 1)
        if chance.random() < self.strange[k]:
            h = chance.choice(STRANGE)
        time_now = chance.choice(STRANGE) if chance.random() < self.strange[k] else self.times[k]
        said = f"time {time_now!r}, step size {h!r}"
        status = self.call(k, "DoStep", c_double(time_now), c_double(h), 1, said=said)
        if status <= WARNING:
            if self.faulty[k]:
                raise Mistake(f"{said}: a step was made after a fault")
            self.times[k] = time_now + h
        else:
            number = c_int()
            if self.call(k, "GetInteger", byref(c_uint(self.fault)), c_size_t(1), byref(number)) == OK:
                self.faulty[k] = number.value != 0
        self.read(k)
        if status == ERROR and chance.random() < 0.6:  # or most calls would find the error state
            self.restart(k)

    def read(self, k: int) -> None:
        status = self.call(k, "GetReal", self.references, c_size_t(len(self.references)), self.values)
        if status <= WARNING:
            wrong = [f"{n} = {x}" for n, x in zip(self.names, self.values, strict=True) if not math.isfinite(x)]
            if wrong:
                raise Mistake(f"{', '.join(wrong[:5])} with status {status}")

    def state(self, k: int) -> None:
        kind = self.chance.random()
        if kind < 0.4:
            state = self.states[k] or c_void_p()
            if self.call(k, "GetFMUstate", byref(state)) <= WARNING:
                self.states[k] = state
        elif kind < 0.6:
            self.restore(k, self.states[k])
        elif kind < 0.65:
            self.foreign_state(k)
        elif self.states[k] is not None:
            self.state_as_bytes(k)

    def restore(self, k: int, state: c_void_p | None) -> None:
        if self.call(k, "SetFMUstate", state) <= WARNING:
            self.faulty[k] = False  # or it is that of the state, which the next step says
            self.read(k)

    def foreign_state(self, k: int) -> None:
        """Hand over what is no state of this instance: one of another, one that was freed, or any memory."""
        values = self.chance.choice([*self.states, self.freed, c_void_p(ctypes.addressof(self.values))])
        local = self.states[k]
        if values is None or (local is not None and values.value == local.value):
            return
        function = self.chance.choice(("SetFMUstate", "SetFMUstate", "FreeFMUstate", "SerializedFMUstateSize"))
        size, address = c_size_t(), c_void_p(values.value)
        arguments = {
            "SetFMUstate": (address,), "FreeFMUstate": (byref(address),),
            "SerializedFMUstateSize": (address, byref(size)),
        }[function]  # fmt: skip
        if self.call(k, function, *arguments, said="of a foreign state") != ERROR:
            raise Mistake(f"fmi2{function} took what is no state of the instance")
        self.counts["foreign states refused"] += 1
        if self.chance.random() < 0.6:  # or most calls would find the error state
            self.restart(k)

    def state_as_bytes(self, k: int) -> None:
        """Hand a state over as bytes, to any instance; such as were changed are refused."""
        chance, size = self.chance, c_size_t()
        if self.call(k, "SerializedFMUstateSize", self.states[k], byref(size)) > WARNING:
            return
        text = ctypes.create_string_buffer(max(size.value, 1))
        if self.call(k, "SerializeFMUstate", self.states[k], text, size) > WARNING:
            return
        data = bytearray(text.raw)
        for _ in range(chance.choice((0, 0, 1, 3))):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
        if chance.random() < 0.1:
            del data[chance.randrange(len(data)) :]
        k = chance.choice([n for n, instance in enumerate(self.instances) if instance is not None])
        copy = c_void_p()
        if self.call(k, "DeSerializeFMUstate", bytes(data), c_size_t(len(data)), byref(copy)) <= WARNING:
            if data != text.raw:
                raise Mistake("bytes of a state were taken that had been changed")
            self.restore(k, copy)
            self.freed = c_void_p(copy.value)
            self.call(k, "FreeFMUstate", byref(copy))
        elif chance.random() < 0.6:
            self.restart(k)

    def anything(self, k: int) -> None:
        """A call that is out of order most of the time."""
        chance = self.chance
        function = chance.choice((
            "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "Terminate", "SetDebugLogging",
            "CancelStep", "GetRealStatus", "GetStringStatus", "GetBooleanStatus", "GetReal", "SetReal", "GetString",
        ))  # fmt: skip
        strange = c_double(chance.choice(STRANGE))
        reference, text, integer = c_uint(chance.randrange(2 * len(self.variables))), c_char_p(), c_int()
        arguments: tuple[Any, ...] = ()
        if function == "SetupExperiment":
            arguments = (1, strange, c_double(chance.choice(STRANGE)), 1, c_double(chance.choice(STRANGE)))
        elif function == "SetDebugLogging":
            arguments = (chance.randrange(2), c_size_t(0), None)
        elif function.endswith("Status"):
            where = {"GetRealStatus": c_double(), "GetStringStatus": text, "GetBooleanStatus": integer}[function]
            arguments = (chance.randrange(5), byref(where))
        elif function == "GetString":
            arguments = (byref(reference), c_size_t(1), byref(text))
        elif function in ("GetReal", "SetReal"):
            arguments = (byref(reference), c_size_t(1), byref(strange))
        self.call(k, function, *arguments)

    def free(self, k: int) -> None:
        instance, state = self.instances[k], self.states[k]
        assert instance is not None
        if state is not None and self.chance.random() < 0.5:  # or it goes with the instance
            self.call(k, "FreeFMUstate", byref(state))
        instance.free()
        self.instances[k] = self.states[k] = None


def main() -> None:
    folder, seed, calls, threads, slowest, file = sys.argv[1:]
    library, variables = Library(Path(folder)), variables_of(Path(folder))
    Path(file).write_bytes(bytes(LINE * int(threads)))
    with Path(file).open("r+b") as opened, mmap.mmap(opened.fileno(), 0) as retained:

        def journal(place: int) -> Any:
            def write(line: str) -> None:
                retained[place * LINE : (place + 1) * LINE] = line.encode().ljust(LINE)[:LINE]

            return write

        with library.instantiate() as first:  # a Python FMU may compile its kernels
            first.begin().step(0)
        callers = [Caller(library, variables, int(seed) + k, journal(k), float(slowest)) for k in range(int(threads))]
        mistakes: list[str] = []

        def run(caller: Caller) -> None:
            try:
                caller.run(int(calls) // len(callers))
            except Mistake as mistake:
                mistakes.append(str(mistake))

        workers = [threading.Thread(target=run, args=(caller,)) for caller in callers]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        counts = sum((caller.counts for caller in callers), collections.Counter())
        sys.stdout.write(json.dumps({"counts": dict(sorted(counts.items())), "mistakes": mistakes}) + "\n")
        sys.stdout.flush()
        os._exit(1 if mistakes else 0)  # PythonFMU's library crashes when Python ends in the usual way


if __name__ == "__main__":
    main()
