"""Call the functions of an FMU as a C host does: they return statuses, and nothing is checked before.

`Library` is an FMU of FMI 2.0, `Library3` one of FMI 3.0. Tests of both name functions as FMI 2.0 does.
"""

from __future__ import annotations

import ctypes
import tempfile
import zipfile
from collections.abc import Sequence
from ctypes import byref, c_bool, c_char_p, c_double, c_int, c_int32, c_int64, c_size_t, c_uint32, c_void_p
from pathlib import Path
from typing import Any, ClassVar, Self
from xml.etree import ElementTree

OK, WARNING, DISCARD, ERROR = range(4)
CO_SIMULATION = 1
OWN = "that of the FMU"
LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
LOGGER3 = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


class Callbacks(ctypes.Structure):
    _fields_ = (
        ("logger", LOGGER),
        ("allocate", c_void_p),
        ("free", c_void_p),
        ("finished", c_void_p),
        ("environment", c_void_p),
    )


class Library:
    """The library of an extracted FMU, or of an archive. Of a variable it knows reference, type and number of values.

    It imports no package of an FMU, so that a process can hide them.
    """

    version = 2
    states = ("instantiated", "initialization mode", "step complete", "terminated", "error")
    kinds: ClassVar[dict[str, Any]] = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}
    makers: tuple[str, ...] = ("",)
    questions: tuple[str, ...] = ("GetVersion", "GetTypesPlatform")

    def __init__(self, fmu: Path | str) -> None:
        folder = Path(fmu)
        if folder.is_file():
            folder = Path(tempfile.mkdtemp())
            zipfile.ZipFile(fmu).extractall(folder)
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.guid = root.get("guid") or root.get("instantiationToken", "")
        resources = folder / "resources"
        self.resources = resources.as_uri() if self.version == 2 else f"{resources}/"
        (self.path,) = folder.glob(f"binaries/*/{root.get('modelName')}.*")
        variables = root.findall("ModelVariables/*")
        self.variables = {v.get("name", ""): self._variable(v) for v in variables}
        self.outputs = [v.get("name", "") for v in variables if v.get("causality") == "output"]
        self.c = ctypes.CDLL(str(self.path))
        for maker in self.makers:
            getattr(self.c, self.function(f"Instantiate{maker}")).restype = c_void_p
        for question in self.questions:
            getattr(self.c, self.function(question)).restype = c_char_p

    @staticmethod
    def _variable(v: ElementTree.Element) -> tuple[int, str, int]:
        return int(v.get("valueReference", "")), v[0].tag.replace("Enumeration", "Integer"), 1

    def instantiate(self, name: bytes | None = b"one", **changes: Any) -> Slave:
        return Slave(self, name, **changes)

    def function(self, name: str) -> str:
        """The name of a function in this version."""
        return f"fmi2{name}"

    def escaped(self, text: str) -> str:
        """A text as the logger gets it, which takes it for a printf format."""
        return text.replace("%", "%%")


class Slave:
    """An instance; `log` holds status, category and text of each message. Values go by name."""

    def __init__(
        self,
        library: Library,
        name: bytes | None,
        kind: int = CO_SIMULATION,
        guid: str | None = OWN,
        logging: int = 1,
        callbacks: bool = True,
        resources: str | None = OWN,
        **others: Any,
    ) -> None:
        self.library = library
        self.log: list[tuple[int, str, str]] = []
        values = library.guid if guid == OWN else guid
        place = library.resources if resources == OWN else resources
        texts = [None if text is None else text.encode() for text in (values, place)]
        self.pointer = self._make(name, kind, *texts, logging, callbacks, **others)

    def _make(
        self, name: bytes | None, kind: int, guid: bytes | None, resources: bytes | None, logging: int, callbacks: bool
    ) -> int | None:
        self._logger = LOGGER(
            lambda _, __, status, category, text: self.log.append((status, category.decode(), text.decode()))
        )
        self.callbacks = Callbacks(self._logger)
        values = byref(self.callbacks) if callbacks else None
        made: int | None = self.library.c.fmi2Instantiate(name, kind, guid, resources, values, 0, logging)
        return made

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.free()

    def free(self) -> None:
        if self.pointer:
            getattr(self.library.c, self.library.function("FreeInstance"))(c_void_p(self.pointer))
            self.pointer = None

    def call(self, function: str, *arguments: Any) -> int:
        return int(getattr(self.library.c, self.library.function(function))(c_void_p(self.pointer), *arguments))

    # Life cycle

    def setup(self, start: float = 0.0, stop: float | None = None) -> int:
        stop_time = c_double(0.0 if stop is None else stop)
        return self.call("SetupExperiment", 0, c_double(0.0), c_double(start), int(stop is not None), stop_time)

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        """Enter initialization mode, with the times of the experiment."""
        return self.setup(start, stop) or self.call("EnterInitializationMode")

    def begin(self, **values: Any) -> Self:
        """Initialise with start values by name (`__` for the dot)."""
        assert [self.set(**values), self.enter()] == [OK] * 2, self.log
        assert self.call("ExitInitializationMode") == OK, self.log
        return self

    def step(self, n: int, h: float = 250e-6) -> int:
        return self.advance(n * h, h)

    def advance(self, time: float, h: float) -> int:
        return self.call("DoStep", c_double(time), c_double(h), 1)

    def debug(self, on: bool, *categories: bytes | None) -> int:
        chosen = (c_char_p * max(len(categories), 1))(*categories)
        return self.call("SetDebugLogging", on, c_size_t(len(categories)), chosen)

    def reason(self) -> str:
        """Return why the last call was refused, as the FMU reports it on request."""
        text = c_char_p(b"nothing")
        assert self.call("GetStringStatus", 1, byref(text)) == OK
        return (text.value or b"").decode()

    def last_time(self) -> float:
        time = c_double()
        assert self.call("GetRealStatus", 2, byref(time)) == OK
        return time.value

    # Variables

    def set(self, **values: Any) -> int:
        for name, settings in values.items():
            reference, kind, _ = self.library.variables[name.replace("__", ".")]
            status = self.transfer("Set", kind, [reference], settings if isinstance(settings, list) else [settings])
            if status != OK:
                return status
        return OK

    def get(self, *names: str) -> list[Any]:
        """The values of variables one after another, those of an array in its order."""
        values: list[Any] = []
        for name in names:
            reference, kind, size = self.library.variables[name]
            numbers = [0] * size
            assert self.transfer("Get", kind, [reference], numbers) <= WARNING, self.log
            values += numbers
        return values

    def transfer(self, way: str, kind: str, references: Sequence[int] | None, values: list[Any] | None) -> int:
        """Set or get values of a kind; values that are read replace those in `values`. None is NULL of length 1."""
        count, n_values = (1 if settings is None else len(settings) for settings in (references, values))
        wanted = None if references is None else (c_uint32 * max(count, 1))(*references)
        number = self.library.kinds[kind]
        buffer = None
        if values is not None:
            buffer = (number * max(n_values, 1))(*(v if number in (c_double, c_char_p) else int(v) for v in values))
        status = self.call(f"{way}{kind}", wanted, c_size_t(count), buffer, *self._sizes(n_values))
        if way == "Get" and values is not None and buffer is not None:
            values[:] = list(buffer)[:n_values]
        return status

    def _sizes(self, n_values: int) -> tuple[c_size_t, ...]:
        return ()

    # Saved states

    def save(self, state: c_void_p | None = None) -> c_void_p:
        state = state or c_void_p()
        assert self.call("GetFMUstate", byref(state)) == OK
        return state

    def restore(self, state: c_void_p | None) -> int:
        return self.call("SetFMUstate", state)

    def serialise(self, state: c_void_p) -> bytes:
        size = c_size_t()
        assert self.call("SerializedFMUstateSize", state, byref(size)) == OK
        text = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, text, size) == OK
        return text.raw

    def deserialise(self, text: bytes) -> tuple[int, c_void_p]:
        state = c_void_p()
        return self.call("DeSerializeFMUstate", text, c_size_t(len(text)), byref(state)), state


class Library3(Library):
    """The library of an extracted FMU of FMI 3.0."""

    version = 3
    states = ("Instantiated", "Initialization Mode", "Step Mode", "Terminated", "Terminated by an error")
    makers = ("CoSimulation", "ModelExchange", "ScheduledExecution")
    questions = ("GetVersion",)
    kinds: ClassVar[dict[str, Any]] = {
        "Float64": c_double,
        "Int32": c_int32,
        "Int64": c_int64,
        "Boolean": c_bool,
        "String": c_char_p,
    }
    names: ClassVar[dict[str, str]] = {
        "Real": "Float64",
        "Integer": "Int32",
        "FMUstate": "FMUState",
        "DeSerialize": "Deserialize",
    }

    @staticmethod
    def _variable(v: ElementTree.Element) -> tuple[int, str, int]:
        size = 1
        for dimension in v.iterfind("Dimension"):
            size *= int(dimension.get("start", ""))
        return int(v.get("valueReference", "")), v.tag, size

    def instantiate(self, name: bytes | None = b"one", **changes: Any) -> Slave3:
        return Slave3(self, name, **changes)

    def function(self, name: str) -> str:
        for two, three in self.names.items():
            name = name.replace(two, three)
        return f"fmi3{name}"

    def escaped(self, text: str) -> str:
        """A text as the logger gets it, for which #123# would be a variable."""
        return text.replace("#", "##")


class Slave3(Slave):
    """An instance of FMI 3.0."""

    def _make(
        self,
        name: bytes | None,
        kind: int,
        guid: bytes | None,
        resources: bytes | None,
        logging: int,
        callbacks: bool,
        events: bool = False,
        intermediate: Sequence[int] = (),
    ) -> int | None:
        self._logger = LOGGER3(
            lambda _, status, category, text: self.log.append((status, category.decode(), text.decode()))
        )
        made: int | None = self.library.c.fmi3InstantiateCoSimulation(
            name,
            guid,
            resources,
            c_bool(False),
            c_bool(logging),
            c_bool(events),
            c_bool(False),
            (c_uint32 * max(len(intermediate), 1))(*intermediate),
            c_size_t(len(intermediate)),
            None,
            self._logger if callbacks else None,
            None,
        )
        return made

    def enter(self, start: float = 0.0, stop: float | None = None) -> int:
        has_stop, end = c_bool(stop is not None), c_double(0.0 if stop is None else stop)
        return self.call("EnterInitializationMode", c_bool(False), c_double(0.0), c_double(start), has_stop, end)

    def advance(self, time: float, h: float) -> int:
        return self.do_step(time, h)[0]

    def do_step(self, time: float, h: float) -> tuple[int, list[bool], float]:
        """Return the status, the flags (event, termination, early return) and the last successful time."""
        flags, last = [c_bool(True) for _ in range(3)], c_double(-1.0)
        ends = [byref(flag) for flag in flags]
        status = self.call("DoStep", c_double(time), c_double(h), c_bool(True), *ends, byref(last))
        return status, [flag.value for flag in flags], last.value

    def last_time(self) -> float:
        return float(self.get("time")[0])

    def _sizes(self, n_values: int) -> tuple[c_size_t, ...]:
        return (c_size_t(n_values),)
