"""Checkpoints that are damaged, or forged as valid archives: the same checkpoint, or one sentence."""

from __future__ import annotations

import io
import json
import random
import zipfile
from contextlib import suppress

import numpy as np
import pytest
from damage import damaged
from mutations import changed_archive, changed_data

from amb_cosim.cosim.run import checkpoint
from amb_cosim.cosim.run.checkpoint import Checkpoint

WHOLE = Checkpoint(
    point=24,
    step_size=1e-3,
    past={"inputs": {"a.u": 1.0}, "events": [[0, "a.u", 2.0]]},
    notice="settled",
    signals={"a.x": 0.5, "b.x": -0.0},
    scales=np.array([1.0, 2.0]),
    recorded=("a.x", "b.x"),
    points=np.arange(0, 25, 2),
    table=np.random.default_rng(1).normal(size=(13, 2)),
    recorded_each=("b.x",),
    steps=np.random.default_rng(2).normal(size=(25, 1)),
    since={"stop": 3},
    states={"a": bytes(range(256)), "b": b"state"},
    warnings={"a": ["limit"], "b": []},
)


def forged_arrays(arrays, chance):
    """One to three arrays changed, exchanged, cut, added, taken away, or of another type or shape."""
    arrays = dict(arrays)
    for _ in range(chance.randint(1, 3)):
        name, other = chance.choice(sorted(arrays)), chance.choice(sorted(arrays))
        array, kind = np.atleast_1d(arrays[name]), chance.randrange(8)
        if kind == 0:
            arrays[name], arrays[other] = arrays[other], array
        elif kind == 1:
            arrays[name] = array[: len(array) // 2]
        elif kind == 2:
            arrays[chance.choice(("x", "state_2", "../x", "head\n", ""))] = array
        elif kind == 3 and len(arrays) > 1:
            del arrays[name]
        elif kind == 4:
            with suppress(ValueError, TypeError), np.errstate(all="ignore"):  # a text that is no number
                arrays[name] = array.astype(chance.choice((np.float32, np.int64, "U8", ">f8", object)))
        elif kind == 5:
            arrays[name] = array.reshape(-1, 1) if array.ndim == 1 else array.T.copy()
        elif kind == 6:
            arrays[name] = chance.choice((np.zeros(0), np.array(np.nan), np.full(array.shape, np.inf), array[::-1]))
        elif array.dtype != object and array.size:
            changed = np.frombuffer(damaged(array.tobytes(), chance), np.uint8)
            arrays[name] = changed.view(array.dtype) if changed.size % array.itemsize == 0 else changed
    return arrays


def forged(content, chance):
    """The bytes of a checkpoint forged at random: its file, its archive, its arrays, or its head."""
    kind = chance.randrange(4)
    if kind == 0:
        return damaged(content, chance)
    if kind == 1:
        return changed_archive(content, chance)
    with np.load(io.BytesIO(content)) as file:
        arrays = dict(file)
    if kind == 2:
        arrays = forged_arrays(arrays, chance)
    else:
        head = changed_data(json.loads(arrays["head"].tobytes()), chance)
        arrays["head"] = np.frombuffer(json.dumps(head).encode(), np.uint8)
    return archive_of(arrays)


def archive_of(arrays):
    """An archive of arrays, objects among them."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            entry = io.BytesIO()
            np.save(entry, array)
            archive.writestr(f"{name}.npy", entry.getvalue())
    return file.getvalue()


@pytest.fixture
def count(is_long):
    return 15_000 if is_long else 300


def loaded(file):
    """The checkpoint of a file, and the sentence that refuses it; one of them is None."""
    try:
        return Checkpoint.load(file), None
    except ValueError as error:
        return None, str(error)


def is_one_sentence(told, file):
    return told.startswith(str(file)) and "\n" not in told and len(told) < len(str(file)) + 100


def test_a_forged_checkpoint_is_the_same_or_one_sentence(tmp_path, first_seed, count):
    file = WHOLE.save(tmp_path / "state.npz")
    whole, read = file.read_bytes(), 0
    for seed in range(first_seed, first_seed + count):
        file.write_bytes(forged(whole, random.Random(seed)))
        result, message = loaded(file)
        if result is None:
            assert is_one_sentence(message, file), f"seed {seed}: {message}"
        else:
            assert result.save(tmp_path / "again.npz").read_bytes() == whole, f"seed {seed}"
            read += 1
    print(f"{count} forged, {read} read")
    assert read < count / 2


def test_a_checkpoint_with_a_forged_checksum_is_read_or_refused(tmp_path, first_seed, count):
    """A checksum does not show who wrote a file: what is read may be anything, but nothing else happens."""
    file = WHOLE.save(tmp_path / "state.npz")
    with np.load(file) as values:
        whole = {name: array for name, array in values.items() if name != "checksum"}
    for seed in range(first_seed, first_seed + count):
        chance = random.Random(seed)
        head = changed_data(json.loads(whole["head"].tobytes()), chance)
        arrays = {**whole, "head": np.frombuffer(json.dumps(head).encode(), np.uint8)}
        arrays = forged_arrays(arrays, chance) if chance.random() < 0.5 else arrays
        file.write_bytes(archive_of({**arrays, "checksum": checkpoint._checksum(arrays)}))
        _, message = loaded(file)
        assert message is None or is_one_sentence(message, file), f"seed {seed}: {message}"
