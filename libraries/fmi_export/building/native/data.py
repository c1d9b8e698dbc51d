"""Writes the data of an FMU (variable table, constants and sentences) in the format that `data.h` describes."""

from __future__ import annotations

import json
import re
import struct
import zlib
from collections.abc import Mapping

import numpy as np

from fmi_export.building.arrays import lengths
from fmi_export.building.units import NOMINAL
from fmi_export.model import STEP_SIZE, Array, Model, Size, Wiring
from fmi_export.variables import Type, Variable

MAGIC, VERSION = b"ambdata\0", 5
TYPES: tuple[Type, ...] = ("Real", "Integer", "Boolean")
NUMBER = 32  # characters that a number in a sentence may take
ROOM = 3584  # bytes of the longest sentence of a model; the slave adds some of its own, up to TEXT_SIZE


def model_data(model: Model, constants: Array, guid: str, key: str, kernels: int = 0) -> bytes:
    """Return the data of an FMU.

    Parameters
    ----------
    model, constants
        The model and its constants, a flat float64 array. For an assembly, these are the constants of its parts.
    guid
        Guid of the FMU.
    key, kernels
        Key of the engine that runs the FMU (see `engines.engine_key`), and index of the model among the engine's
        models.

    Raises
    ------
    ValueError
        If the sentence of a fault names an unknown variable, if a sentence is too long, or if an array of FMI 3.0 is
        invalid.
    """
    table, texts = model.interface, _Texts(model.name)
    described = zip(table.variables, lengths(table), strict=True)
    variables = b"".join(_variable(v, length, texts) for v, length in described)
    pieces: list[bytes] = []
    faults = _sentences(model, model.faults, pieces, texts)
    warnings = _sentences(model, table.warnings, pieces, texts)
    if model.wiring:
        content = _wired(model, model.wiring, guid, key, texts)
    else:
        content = np.ascontiguousarray(constants, dtype="<f8").tobytes()
    counts = (
        *(table.n_parameters, table.n_inputs, table.n_outputs, *sizes(model, constants), len(content) // 8),
        *(len(model.faults), len(table.warnings), len(pieces), len(texts.content), kernels, len(model.parts)),
    )
    parts = [HEADER.pack(MAGIC, VERSION, key.encode(), guid.encode(), *counts), content]
    parts += [np.asarray(numbers, "<f8").tobytes() for numbers in (table.start, table.minimum, table.maximum)]
    parts += [faults, warnings, variables, b"".join(pieces)]
    parts += [bytes(TYPES.index(v.type) for v in table.variables), bytes(texts.content)]
    content = b"".join(parts)
    return content + struct.pack("<I", zlib.crc32(content))


HEADER = struct.Struct("<8sQ32s48s12Q")
WIRING = struct.Struct("<5qd")
PART = struct.Struct("<3Qq")
VARIABLE = struct.Struct("<5If")
PIECE = struct.Struct("<Ii")
SENTENCE = struct.Struct("<qII")


class _Texts:
    """All texts of the data, without repetition, each terminated by a zero byte."""

    def __init__(self, model: str) -> None:
        self.model = model
        self.content = bytearray()
        self._places: dict[str, int] = {}

    def place(self, text: str) -> int:
        if text not in self._places:
            self._places[text] = len(self.content)
            self.content += text.encode() + b"\0"
        return self._places[text]

    def check(self, sentence: str, numbers: int) -> None:
        """Raise a ValueError if the engine would truncate a sentence."""
        size = len(sentence.encode()) + NUMBER * numbers
        if size > ROOM:
            raise ValueError(
                f"{self.model}: a message of an FMU must fit in {ROOM} bytes; this one needs up to {size}: {sentence}"
            )


def sizes(model: Model, constants: Array) -> tuple[int, int]:
    """Return the sizes (1 or more) of a model's state and work array; those of an assembly match `assembly.c`."""
    if not model.parts:
        return _size(model.n_state, constants), _size(model.n_work, constants)
    n_state, n_work = 2, 0  # a clock
    table = model.interface
    n_state += _even(table.n_inputs + table.n_outputs - 1)
    for part in model.parts:
        local, (state, work) = part.model.interface, sizes(part.model, part.constants)
        n_state += _even(len(local.variables)) + _even(state)
        n_work += _even(local.n_outputs) + _even(work)
    return n_state, n_work


def linear_state_file(model: Model, constants: Array) -> dict[str, bytes]:
    """Return, by path, the file that describes the linear part of the state; empty if that part is unknown."""
    if model.linear_state is None:
        return {}
    places = {"size": sizes(model, constants)[0], **model.linear_state(constants)._asdict()}
    return {"resources/linear_state.json": json.dumps(places, indent=1).encode()}


def _size(size: Size, constants: Array) -> int:
    return max(size(constants) if callable(size) else size, 1)


def _even(size: int) -> int:
    return size + size % 2


def _wired(model: Model, wiring: Wiring, guid: str, key: str, texts: _Texts) -> bytes:
    """Return the constants of an assembly: its wiring, the headers of its parts, tables, and the data of each part."""
    counts = len(wiring.sources), len(wiring.ramps), len(wiring.gathered)
    time = wiring.sample_time
    fixed, parameter = (0.0, model.interface.position[time]) if isinstance(time, str) else (time, -1)
    pairs = [number for pair in (*wiring.ramps, *wiring.gathered) for number in pair]
    tables = np.array([*wiring.sources, *pairs], "<i8").tobytes()
    content = _padded(bytes(WIRING.size + len(model.parts) * PART.size) + tables)
    headers = []
    names = [compiled.name for compiled in model.compiled]
    for part in model.parts:
        data = model_data(part.model, part.constants, guid, key, names.index(part.model.name))
        headers.append(PART.pack(texts.place(part.name), len(content), len(data), part.every))
        content += _padded(data)
    head = WIRING.pack(*counts, wiring.jacobi, parameter, fixed) + b"".join(headers)
    return head + content[len(head) :]


def _padded(content: bytes) -> bytes:
    """Return the bytes, padded with zeros to a length that is a multiple of 16."""
    return content.ljust(-(-len(content) // 16) * 16, b"\0")


def _variable(v: Variable, length: int, texts: _Texts) -> bytes:
    sentence = v.describe_range(0.0)
    texts.check(sentence, 1)
    allowed = sentence.removeprefix(f"{v.name} = 0")
    kind = f"{v.variability} {v.causality}"
    places = (texts.place(text) for text in (v.name, kind, allowed))
    return VARIABLE.pack(*places, v.tunable, length, NOMINAL.get(v.unit, 1.0))


def _sentences(model: Model, sentences: Mapping[int, str], pieces: list[bytes], texts: _Texts) -> bytes:
    """Return the packed sentences of numbered faults or warnings, and append their parts to `pieces`."""
    position = {**model.interface.position, STEP_SIZE: -2, "": -1}
    packed: list[bytes] = []
    for number, sentence in sentences.items():
        texts.check(sentence, sentence.count("{"))
        first = len(pieces)
        for text, name in re.findall(r"([^{]*)(?:\{([^}]+)\})?", sentence):
            if name not in position:
                raise ValueError(
                    f"{model.name}: the message of a fault names {name!r}, which is not a variable: {sentence!r}"
                )
            if text or name:
                pieces.append(PIECE.pack(texts.place(text), position[name]))
        packed.append(SENTENCE.pack(number, first, len(pieces) - first))
    return b"".join(packed)
