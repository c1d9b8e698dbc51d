"""Result files: they are read back without loss, and damage is detected."""

import json
import random
import sys
from functools import partial

import numpy as np
import pytest
import xarray as xr
from slow import slow_but_first

from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.cosim.run.dataset import load, save
from amb_cosim.results.result import Result
from tests.support.messages import assert_names


@pytest.mark.slow
@pytest.mark.parametrize("of", ["signals", "dataset"])
def test_turned_bits_of_a_result_are_harmless_or_an_error(synthetic, tmp_path, of):
    dataset = synthetic(outcome=json.dumps(["completed", 1.0, None, ""]))
    groups = ({n: Samples(v.values, v.attrs) for n, v in g.items()} for g in (dataset.data_vars, dataset.coords))
    save(SignalTable(*groups, dataset.attrs) if of == "signals" else dataset, file := tmp_path / "result.nc")
    whole, chance, refused = file.read_bytes(), random.Random(1), 0
    for _ in range(25):
        content = bytearray(whole)
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        file.write_bytes(content)
        try:
            assert Result.load(file).dataset.equals(dataset)
        except ValueError:
            refused += 1
    assert refused == 25
    at = whole.index(b"TREE") + 24  # a list of chunks, of which HDF5 has no checksum
    file.write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
    with pytest.raises(ValueError, match="its checksum does not match its content"):
        Result.load(file)
    file.write_bytes(whole[:-4])  # as another program leaves it
    assert Result.load(file).dataset.equals(dataset)
    file.write_bytes(whole[: len(whole) // 4])
    with pytest.raises(ValueError, match="is not a result of a run, or is damaged"):
        Result.load(file)


@pytest.mark.parametrize("samples", slow_but_first([None, 0]))
def test_the_signal_file_equals_that_of_xarray(synthetic, tmp_path, samples):
    dataset = synthetic(plot_cycles=[4, 16], description="Ω, ½", failure="").isel(time=slice(samples))
    flags = {"flag_values": np.array([0, 1], np.int32), "flag_meanings": "held free"}
    dataset["rotor_contact.free"] = ("time", np.zeros(dataset.sizes["time"], np.int8), {"units": "1", **flags})
    groups = ({n: Samples(v.values, v.attrs) for n, v in g.items()} for g in (dataset.data_vars, dataset.coords))
    signals = SignalTable(*groups, dataset.attrs)
    xr.testing.assert_identical(signals.to_dataset(), dataset)
    for name, content in (("signals", signals), ("dataset", dataset)):
        save(content, tmp_path / name)
    result, expected = load(tmp_path / "signals"), load(tmp_path / "dataset")
    xr.testing.assert_identical(result, expected)
    assert list(result.variables) == list(expected.variables)
    assert {n: v.dtype for n, v in result.variables.items()} == {n: v.dtype for n, v in expected.variables.items()}
    assert [(n, type(v)) for n, v in result.attrs.items()] == [(n, type(v)) for n, v in expected.attrs.items()]


@pytest.mark.parametrize(
    "unit", ["hours", "days", "seconds", "ms", "seconds since 2000-01-01", "days since 1900-01-01"]
)
def test_numbers_with_a_unit_of_time_stay_numbers(tmp_path, monkeypatch, unit):
    """Before 2026, xarray made times of such numbers without being asked."""
    monkeypatch.setattr(xr, "open_dataset", partial(xr.open_dataset, decode_timedelta=True))
    time = Samples(np.array([0.0, 1.0, 2.0]), {"units": "s"})
    table = SignalTable({"one.t": Samples(np.array([1.0, 2.0, 0.5]), {"units": unit})}, {"time": time}, {})
    save(table, tmp_path / "result.nc")
    loaded = load(tmp_path / "result.nc")
    for name, values in (("one.t", [1.0, 2.0, 0.5]), ("time", [0.0, 1.0, 2.0])):
        assert loaded[name].dtype == np.float64
        np.testing.assert_array_equal(loaded[name].values, values)
    assert loaded["one.t"].attrs["units"] == unit


NAMES = ["one.p/q", "one./lead", "one.load/", "one.a/b/c", "one.p\N{DIVISION SLASH}q", "one.z"]


@pytest.mark.parametrize("of", ["signals", "dataset"])
def test_names_with_slashes_are_read_back(tmp_path, of):
    """A slash is a path of HDF5: `p/q` became a group with q, which readers do not see, and `load/` an error."""
    samples = {name: Samples(np.arange(3.0) + k, {"units": "1"}) for k, name in enumerate(NAMES)}
    table = SignalTable(samples, {"time": Samples(np.arange(3.0), {"units": "s"})}, {"system": "a/b"})
    save(table if of == "signals" else table.to_dataset(), tmp_path / "result.nc")
    loaded = load(tmp_path / "result.nc")
    assert set(loaded.data_vars) == set(NAMES)
    for name, expected in samples.items():
        np.testing.assert_array_equal(loaded[name].values, expected.values)
        assert loaded[name].attrs["units"] == "1"
    xr.testing.assert_identical(loaded[NAMES], table.to_dataset()[NAMES])


@pytest.mark.skipif(sys.platform != "linux", reason="other systems do not bound the memory of a process")
@pytest.mark.parametrize("free", [0, 10, 20])
def test_a_record_that_memory_cannot_hold_is_an_error_with_its_size(tmp_path, run_python, free):
    """HDF5 ends the process when it cannot enlarge a file in memory."""
    assert_names(run_python(f"{RECORD}\nresult = trial({free})", cwd=tmp_path), "memory", "16 MB")
    assert not list(tmp_path.iterdir())


RECORD = """
import resource
from pathlib import Path
import numpy as np
from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.cosim.run.dataset import save
noise = np.random.default_rng(0).standard_normal(200_000)
signals = {f"one.x{k}": Samples(noise, {"units": "m"}) for k in range(9)}
table = SignalTable(signals, {"time": Samples(np.arange(200_000.0), {"units": "s"})}, {"outcome": "[]"})

def trial(free):
    now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + free * 10**6,) * 2)
    try:
        save(table, Path("result.nc"))
    except OSError as error:
        return str(error)
"""
