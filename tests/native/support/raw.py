"""Call the functions of a native FMU as a C host does: they return statuses, and nothing is checked before."""

from __future__ import annotations

import ctypes
from ctypes import byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

OK, WARNING, DISCARD, ERROR = range(4)
CO_SIMULATION = 1
OWN = "that of the FMU"
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", LOGGER),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("finished", c_void_p),
        ("environment", c_void_p),
    )


class Library:
    """The library of an extracted FMU."""

    def __init__(self, folder: Path) -> None:
        from fmi_export.building.native.compiler import PLATFORMS, host_platform

        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        here = host_platform()
        self.guid = root.get("guid", "")
        self.resources = (folder / "resources").as_uri()
        self.path = folder / "binaries" / here / f"{root.get('modelName')}{PLATFORMS[here][0]}"
        self.variables = {
            v.get("name"): (int(v.get("valueReference", "")), v[0].tag.replace("Enumeration", "Integer"))
            for v in root.iterfind("ModelVariables/*")
        }
        self.c = ctypes.CDLL(str(self.path))
        self.c.fmi2Instantiate.restype = c_void_p
        self.c.fmi2GetVersion.restype = self.c.fmi2GetTypesPlatform.restype = c_char_p

    def instantiate(
        self,
        name: bytes | None = b"one",
        kind: int = CO_SIMULATION,
        guid: str | None = OWN,
        logging: int = 1,
        callbacks: bool = True,
        resources: str | None = OWN,
    ) -> Slave:
        guid, resources = (self.guid if guid == OWN else guid), (self.resources if resources == OWN else resources)
        return Slave(self, name, kind, guid, logging, callbacks, resources)


class Slave:
    """An instance; `log` holds status, category and text of each message. Values go by name."""

    def __init__(
        self,
        library: Library,
        name: bytes | None,
        kind: int,
        guid: str | None,
        logging: int,
        callbacks: bool,
        resources: str | None,
    ) -> None:
        self.library = library
        self.log: list[tuple[int, str, str]] = []
        self._logger = LOGGER(
            lambda _, __, status, category, text: self.log.append((status, category.decode(), text.decode()))
        )
        self.callbacks = Callbacks(self._logger)
        given, location = (None if text is None else text.encode() for text in (guid, resources))
        self.pointer = library.c.fmi2Instantiate(
            name, kind, given, location, byref(self.callbacks) if callbacks else None, 0, logging
        )

    def __enter__(self) -> Slave:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()

    def free(self) -> None:
        if self.pointer:
            self.library.c.fmi2FreeInstance(c_void_p(self.pointer))
            self.pointer = None

    def call(self, function: str, *arguments: Any) -> int:
        return int(getattr(self.library.c, f"fmi2{function}")(c_void_p(self.pointer), *arguments))

    def setup(self, start: float = 0.0, stop: float | None = None) -> int:
        stop_time = c_double(0.0 if stop is None else stop)
        return self.call("SetupExperiment", 0, c_double(0.0), c_double(start), int(stop is not None), stop_time)

    def begin(self, **values: float) -> Slave:
        """Initialise with start values by name (`__` for the dot)."""
        statuses = [self.set(**values), self.setup(), self.call("EnterInitializationMode")]
        assert statuses == [OK] * 3, self.log
        assert self.call("ExitInitializationMode") == OK, self.log
        return self

    def set(self, **values: float) -> int:
        for name, value in values.items():
            reference, kind = self.library.variables[name.replace("__", ".")]
            number = c_double(value) if kind == "Real" else c_int(int(value))
            status = self.call(f"Set{kind}", byref(c_uint(reference)), c_size_t(1), byref(number))
            if status != OK:
                return status
        return OK

    def get(self, *names: str) -> list[float]:
        values = []
        for name in names:
            reference, kind = self.library.variables[name]
            number = c_double() if kind == "Real" else c_int()
            status = self.call(f"Get{kind}", byref(c_uint(reference)), c_size_t(1), byref(number))
            assert status <= WARNING, self.log
            values.append(number.value)
        return values

    def step(self, n: int, h: float = 250e-6) -> int:
        return self.call("DoStep", c_double(n * h), c_double(h), 1)

    def save(self, state: c_void_p | None = None) -> c_void_p:
        state = state or c_void_p()
        assert self.call("GetFMUstate", byref(state)) == OK
        return state

    def serialise(self, state: c_void_p) -> bytes:
        size = c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == OK
        text = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, text, size) == OK
        return text.raw

    def deserialise(self, text: bytes) -> tuple[int, c_void_p]:
        state = c_void_p()
        return self.call("DeSerializeFMUstate", text, c_size_t(len(text)), byref(state)), state

    def reason(self) -> str:
        """Why the last call was refused, as the FMU tells a host that asks."""
        text = c_char_p(b"nothing")
        assert self.call("GetStringStatus", 1, byref(text)) == OK
        return (text.value or b"").decode()

    def last_time(self) -> float:
        time = c_double()
        assert self.call("GetRealStatus", 2, byref(time)) == OK
        return time.value
