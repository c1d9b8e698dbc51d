"""Results and checkpoints with random changes whose checksums hold: what a forger, not a disk, would leave."""

from __future__ import annotations

import io
import json
import random
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from mutations import _places, _value, changed_bytes, changed_text

from amb_cosim.cosim.run.checkpoint import _checksum

CHECKSUM = 4  # bytes at the end of a result; a file without them is read, too
NESTED = "a value nested deep"  # stands for it, because Python writes no JSON that is nested this deep
DEPTHS = (100, 800, 50_000)  # two that its reader follows, and one that it refuses


def nested(depth: int) -> str:
    """JSON of lists in lists."""
    return "[" * depth + "]" * depth


def changed_array(values: Any, chance: random.Random) -> Any:
    """An array with another number, type, length or number of dimensions."""
    kind = chance.randrange(7)
    if kind == 0 and values.size and values.dtype.kind == "f":
        values = values.copy()
        values.flat[chance.randrange(values.size)] = chance.choice((np.nan, np.inf, -1e300, 1e300, 5e-324, 0.0))
    elif kind == 1:
        values = values.astype(chance.choice(("f4", ">f8", "i8", "u1", "c16", "S8", "bool")))
    elif kind == 2:
        values = values[: chance.randrange(len(values) + 1)] if values.ndim else values
    elif kind == 3:
        values = np.concatenate([values, values[:1]]) if values.ndim else values
    elif kind == 4:
        values = values.reshape((-1, 1))
    elif kind == 5:
        values = values[::-1] if values.ndim else values
    else:
        values = np.array(chance.choice((0.0, np.nan, 1e300)))
    return values


def changed_json(text: str, chance: random.Random) -> str:
    """JSON with a value replaced, taken away or nested deep; text that Python cannot read is changed as a text."""
    try:
        data = json.loads(text)
        places = list(_places(data))
        if not places or chance.random() < 0.1:
            return chance.choice(("", "null", "[]", "{}", "3", '"x"', *map(nested, DEPTHS)))
        container, key = chance.choice(places)
        if chance.random() < 0.3:
            del container[key]
        else:
            container[key] = NESTED if chance.random() < 0.1 else _value(chance)
        text = json.dumps(data)
    except (ValueError, RecursionError):
        return changed_text(text, chance)
    return text.replace(json.dumps(NESTED), nested(chance.choice(DEPTHS)))


def _changed_attribute(owner: Any, chance: random.Random) -> None:
    names = [name for name in owner.attrs if name not in ("DIMENSION_LIST", "REFERENCE_LIST")]
    if not names:
        return
    name, kind = chance.choice(names), chance.random()
    value = owner.attrs[name]
    del owner.attrs[name]
    if kind < 0.4 and isinstance(value, str) and value[:1] in ("{", "["):
        owner.attrs[name] = changed_json(value, chance)
    elif kind < 0.8:
        owner.attrs[name] = chance.choice(("", "x", "a" * 5000, "\x1b[31m", 3, -1.0, np.nan, 1e300, [1.0, 2.0], "[]"))


def changed_result(data: bytes, chance: random.Random, folder: Path) -> bytes:
    """A result with one to three changed attributes or arrays, without its checksum; or changed in its bytes."""
    data = data[:-CHECKSUM]
    if chance.random() < 0.2:
        return changed_bytes(data, chance)
    path = folder / "forged.nc"
    path.write_bytes(data)
    with h5py.File(path, "a") as file:
        for _ in range(chance.randint(1, 3)):
            arrays = [name for name in file if isinstance(file[name], h5py.Dataset)]
            name, kind = chance.choice(arrays), chance.random()
            if kind < 0.3:
                _changed_attribute(file, chance)
            elif kind < 0.5:
                _changed_attribute(file[name], chance)
            elif kind < 0.6:
                new = [other for other in ("x", "time2", "one.x/y", "..", "\x1b[2J", "a" * 300) if other not in file]
                file.move(name, chance.choice(new))
            elif kind < 0.7:
                del file[name]
            else:
                scale = name == "time" or file[name].is_scale
                values, attributes = changed_array(file[name][()], chance), dict(file[name].attrs)
                del file[name]
                made = file.create_dataset(name, data=values)
                for key in set(attributes) - {"DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"}:
                    made.attrs[key] = attributes[key]
                if scale:
                    made.make_scale(name)
                elif made.ndim and "time" in file and file["time"].is_scale:
                    made.dims[0].attach_scale(file["time"])
    return path.read_bytes()


def changed_checkpoint(data: bytes, chance: random.Random, folder: Path) -> bytes:
    """A checkpoint with changed arrays or a changed head, and the checksum of that; or changed in its bytes."""
    if chance.random() < 0.2:
        return changed_bytes(data, chance)
    path = folder / "forged.npz"
    path.write_bytes(data)
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files if name != "checksum"}
    for _ in range(chance.randint(1, 2)):
        name = chance.choice(list(arrays))
        if name == "head" or chance.random() < 0.5:
            head = arrays["head"].astype(np.uint8).tobytes().decode("utf-8", "replace")
            arrays["head"] = np.frombuffer(changed_json(head, chance).encode(), np.uint8)
        elif name.startswith("state_"):
            arrays[name] = np.frombuffer(changed_bytes(arrays[name].astype(np.uint8).tobytes(), chance), np.uint8)
        else:
            arrays[name] = changed_array(arrays[name], chance)
    return signed(arrays)


def signed(arrays: dict[str, Any]) -> bytes:
    """The file of a checkpoint with these arrays, and their checksum."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in {**arrays, "checksum": _checksum(arrays)}.items():
            with archive.open(f"{name}.npy", "w") as entry:
                np.lib.format.write_array(entry, np.asanyarray(array))
    return stream.getvalue()


VALUES = ("", "x", "\x1b[2J", 3, -1, 0, 1e300, float("nan"), float("inf"), None, True, [], {}, [[]], 2**70, "1", 0.5)
TYPES = ("f2", "f4", ">f8", "i8", "u1", "c16", "S8", "U8", "bool", "M8[s]", "O8")


def every_checkpoint(data: bytes, chance: random.Random) -> Iterator[tuple[str, bytes]]:
    """Each part of a checkpoint forged in turn, with a title: what differs is no number that a run could have had."""
    with np.load(io.BytesIO(data)) as file:
        arrays = {name: file[name] for name in file.files if name != "checksum"}
    head = json.loads(arrays["head"].tobytes())
    for k in range(len(list(_places(head)))):
        for value in ("missing", *chance.sample(VALUES, 2)):
            changed = json.loads(json.dumps(head))
            container, key = list(_places(changed))[k]
            if value == "missing":
                del container[key]
            else:
                container[key] = value
            yield f"{key} of place {k}: {value!r}", signed({**arrays, "head": _bytes(json.dumps(changed))})
    for name, array in arrays.items():
        yield f"{name} is missing", signed({other: arrays[other] for other in arrays if other != name})
        for kind in TYPES:
            if array.dtype != (other := np.dtype(kind) if kind != "O8" else np.dtype("V8")):
                yield f"{name} of {kind}", signed({**arrays, name: np.zeros(array.shape, other)})
        for title, shape in {
            "scalar": (),
            "none": (0, *array.shape[1:]),
            "rows": (len(array) + 1, *array.shape[1:]),
        }.items():
            if array.shape != shape:
                yield f"{name}, {title}", signed({**arrays, name: np.zeros(shape, array.dtype)})
    yield "another array", signed({**arrays, "extra": np.zeros(1)})


def _bytes(text: str) -> Any:
    return np.frombuffer(text.encode(), np.uint8)
