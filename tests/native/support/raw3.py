"""Call the functions of a native FMU of FMI 3.0 as a C host does; the counterpart of `raw` for FMI 2.0."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint32, c_void_p
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

OK, WARNING, DISCARD, ERROR = range(4)
OWN = "that of the FMU"
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
KINDS = {"Float64": c_double, "Int32": c_int32, "Int64": c_int64, "Boolean": c_bool}


class Library3:
    """The library of an extracted FMU. Of a variable it knows reference, type and number of values."""

    def __init__(self, folder: Path) -> None:
        from fmi_export.building.native.compiler import FOLDERS3, PLATFORMS, host_platform

        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        here = host_platform()
        self.token = root.get("instantiationToken", "")
        self.resources = f"{folder / 'resources'}/"
        self.path = folder / "binaries" / FOLDERS3[here][0] / f"{root.get('modelName')}{PLATFORMS[here][0]}"
        self.variables: dict[str, tuple[int, str, int]] = {}
        for v in root.iterfind("ModelVariables/*"):
            size = 1
            for dimension in v.iterfind("Dimension"):
                size *= int(dimension.get("start", ""))
            self.variables[v.get("name", "")] = (int(v.get("valueReference", "")), v.tag, size)
        self.c = ctypes.CDLL(str(self.path))
        for kind in ("CoSimulation", "ModelExchange", "ScheduledExecution"):
            getattr(self.c, f"fmi3Instantiate{kind}").restype = c_void_p
        self.c.fmi3GetVersion.restype = c_char_p

    def instantiate(self, **changes: Any) -> Slave3:
        return Slave3(self, **changes)


class Slave3:
    """An instance; `log` holds status, category and text of each message. Values go by name."""

    def __init__(
        self,
        library: Library3,
        name: bytes | None = b"one",
        token: str | None = OWN,
        resources: str | None = OWN,
        logging: bool = True,
        events: bool = False,
        intermediate: Sequence[int] = (),
        has_logger: bool = True,
    ) -> None:
        self.library = library
        self.log: list[tuple[int, str, str]] = []
        self._logger = LOGGER(
            lambda _, status, category, text: self.log.append((status, category.decode(), text.decode()))
        )
        given = library.token if token == OWN else token
        place = library.resources if resources == OWN else resources
        self.pointer = library.c.fmi3InstantiateCoSimulation(
            name,
            None if given is None else given.encode(),
            None if place is None else place.encode(),
            c_bool(False),
            c_bool(logging),
            c_bool(events),
            c_bool(False),
            (c_uint32 * max(len(intermediate), 1))(*intermediate),
            c_size_t(len(intermediate)),
            None,
            self._logger if has_logger else None,
            None,
        )

    def __enter__(self) -> Slave3:
        return self

    def __exit__(self, *_: object) -> None:
        if self.pointer:
            self.library.c.fmi3FreeInstance(c_void_p(self.pointer))
            self.pointer = None

    def call(self, function: str, *arguments: Any) -> int:
        return int(getattr(self.library.c, f"fmi3{function}")(c_void_p(self.pointer), *arguments))

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        has_stop, end = c_bool(stop is not None), c_double(0.0 if stop is None else stop)
        return self.call("EnterInitializationMode", c_bool(False), c_double(0.0), c_double(start), has_stop, end)

    def begin(self, **values: Any) -> Slave3:
        """Initialise with start values by name (`__` for the dot)."""
        assert self.set(**values) == OK, self.log
        assert self.enter() == OK, self.log
        assert self.call("ExitInitializationMode") == OK, self.log
        return self

    def set(self, **values: Any) -> int:
        for name, given in values.items():
            reference, kind, _ = self.library.variables[name.replace("__", ".")]
            numbers = given if isinstance(given, list | tuple) else [given]
            status = self.transfer("Set", kind, [reference], numbers)
            if status != OK:
                return status
        return OK

    def get(self, *names: str) -> list[Any]:
        """The values of variables one after another, those of an array in its order."""
        values = []
        for name in names:
            reference, kind, size = self.library.variables[name]
            numbers = [0] * size
            assert self.transfer("Get", kind, [reference], numbers) <= WARNING, self.log
            values += numbers
        return values

    def transfer(self, way: str, kind: str, references: Sequence[int], values: Any, n_values: int | None = None) -> int:
        """Call fmi3Set<kind> or fmi3Get<kind>; what is got replaces the content of `values`."""
        buffer = (KINDS[kind] * max(len(values), 1))(*values)
        wanted = (c_uint32 * max(len(references), 1))(*references)
        count = len(values) if n_values is None else n_values
        status = self.call(f"{way}{kind}", wanted, c_size_t(len(references)), buffer, c_size_t(count))
        if way == "Get":
            values[:] = list(buffer)[: len(values)]
        return status

    def step(self, n: int, h: float = 250e-6) -> int:
        return self.do_step(n * h, h)[0]

    def do_step(self, time: float, h: float) -> tuple[int, list[bool], float]:
        """Return the status, the flags (event, termination, early return) and the last successful time."""
        flags, last = [c_bool(True) for _ in range(3)], c_double(-1.0)
        ends = [byref(flag) for flag in flags]
        status = self.call("DoStep", c_double(time), c_double(h), c_bool(True), *ends, byref(last))
        return status, [flag.value for flag in flags], last.value

    def save(self) -> c_void_p:
        state = c_void_p()
        assert self.call("GetFMUState", byref(state)) == OK
        return state
