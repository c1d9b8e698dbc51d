"""Controllers as files of arrays or of blocks, damaged or changed: a controller of finite numbers, or one sentence."""

from __future__ import annotations

import io
import random
import resource
import sys
import zipfile

import numpy as np
import pytest
from mutations import changed_bytes, changed_toml
from scipy.io import savemat

from amb_cosim import linear_controller
from amb_files.packs import packs

SPACE = 4 * 2**30  # bytes of memory that a file may ask for beside what the process has
N_STATES, N_SPEEDS = 3, 2


def good(chance):
    """The arrays of a law, now and then over two speeds."""
    rng = np.random.default_rng(chance.randrange(2**32))
    shapes = {"A": (N_STATES, N_STATES), "B": (N_STATES, 2), "C": (1, N_STATES), "D": (1, 2)}
    more = (N_SPEEDS,) if chance.random() < 0.5 else ()
    arrays = {name: 0.1 * rng.normal(size=(*shape, *more)) for name, shape in shapes.items()}
    arrays |= {"Ts": np.array(1e-4), "inputs": np.array(["a", "b"]), "outputs": np.array(["u"])}
    return arrays | ({"speeds": np.array([100.0, 200.0])} if more else {})


def forged(arrays, chance):
    """One to three of the arrays replaced, taken away, exchanged, cut, or with another value."""
    arrays = dict(arrays)
    for _ in range(chance.randint(1, 3)):
        name = chance.choice([*arrays, "slow_time", "allow_unstable", "start_names", "start_values", "speeds"])
        kind = chance.randrange(8)
        value = arrays.get(name, np.zeros(1))
        if kind == 0:
            arrays.pop(name, None)
        elif kind == 1:
            arrays[name] = arrays[chance.choice([*arrays])]
        elif kind == 2:
            shape = [chance.choice((0, 1, 2, 3, 5)) for _ in range(chance.randrange(5))]
            arrays[name] = np.full(shape, chance.choice((0.0, 1.0, 1e-320)))
        elif kind == 3:
            arrays[name] = np.asarray(value).astype(
                chance.choice((complex, "S8", "U8", bool, np.int8, np.float16, ">f8"))
            )
        elif kind == 4:
            arrays[name] = np.array(chance.choice(("", "x", "a\nb", "\u03a9" * 300, b"\xff\xfe")))
        elif kind == 5:
            arrays[name] = np.array([None, {"a": 1}, lambda_free], object)
        elif np.size(value) and np.asarray(value).dtype.kind == "f":
            changed = np.array(value, float)
            strange = (np.nan, np.inf, -np.inf, 1e300, -1e300, 5e-324, 1e6, -0.0)
            changed.ravel()[chance.randrange(changed.size)] = chance.choice(strange)
            arrays[name] = changed
    return arrays


def lambda_free():
    """What a pickle may name."""


def npz(arrays, chance):
    """An archive of the arrays; now and then one says that it holds more than there is."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    if chance.random() > 0.1:
        return file.getvalue()
    packed = io.BytesIO()
    with zipfile.ZipFile(file) as whole, zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        chosen = chance.choice(whole.namelist())
        for name in whole.namelist():
            if name == chosen:
                n = chance.choice((10**4, 10**5, 10**9))
                head = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({n}, {n}), }}".encode()
                content = b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head
                archive.writestr(name, content + bytes(chance.choice((0, 10**6))))
            else:
                archive.writestr(name, whole.read(name))
    return packed.getvalue()


def mat(arrays, chance):
    file = io.BytesIO()
    cells = {k: np.asarray(v).astype(object) if np.asarray(v).dtype.kind in "US" else v for k, v in arrays.items()}
    savemat(file, cells, do_compression=chance.random() < 0.5)
    return file.getvalue()


def changed_arrays(write):
    """A function that gives a file of arrays, with or without mistakes in its arrays and bytes."""

    def content(chance):
        arrays = good(chance)
        try:
            whole = write(forged(arrays, chance) if chance.random() < 0.7 else arrays, chance)
        except Exception:  # what no writer takes
            whole = write(arrays, chance)
        return changed_bytes(whole, chance) if chance.random() < 0.4 else whole

    return content


def blocks(chance):
    """A controller of blocks, mostly with mistakes."""
    folder = packs()["rotor_literature"] / "controllers"
    text = chance.choice(sorted(folder.glob("*.toml"))).read_text(encoding="utf-8")
    return changed_toml(text, chance) if chance.random() < 0.9 else text.encode()


@pytest.fixture
def little_memory():
    """So that a file which asks for more than there is gets an error and no other program suffers."""
    if sys.platform != "linux":
        yield
        return
    before = resource.getrlimit(resource.RLIMIT_AS)
    with open("/proc/self/statm") as file:  # noqa: PTH123
        now = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + SPACE, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


@pytest.mark.parametrize(
    ("suffix", "content", "count", "longest"),
    [
        (".npz", changed_arrays(npz), 300, 10_000),
        (".toml", blocks, 100, 1000),
        pytest.param(".mat", changed_arrays(mat), 20, 200, marks=pytest.mark.slow),
    ],
)
def test_a_forged_file_is_a_controller_or_one_sentence(
    little_memory, tmp_path, first_seed, is_long, suffix, content, count, longest
):
    refused, n = 0, longest if is_long else count
    for seed in range(first_seed, first_seed + n):
        file = tmp_path / f"law{suffix}"
        file.write_bytes(content(random.Random(seed)))
        try:
            controller = linear_controller(file)
        except ValueError as error:
            refused += 1
            message = str(error)
            assert all(line.startswith(f"{file}: ") for line in message.split("\n")), f"seed {seed}: {message}"
            assert suffix == ".toml" or len(message) < 1000, f"seed {seed}: {message[:500]}"
            assert "allow_pickle" not in message, f"seed {seed}: {message}"
            continue
        assert np.isfinite(controller.model_and_constants[1]).all(), f"seed {seed}"
    print(f"{n} forged, {refused} refused")
    assert 0 < refused < n
