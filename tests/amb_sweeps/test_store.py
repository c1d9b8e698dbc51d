"""Stores of sweeps: damage is reported and never read as numbers; foreign files are left untouched."""

import json
import os
import random
import shutil
import tomllib
from functools import partial

import numpy as np
import pytest
import xarray as xr

from amb_cosim.scenario.scenario import as_scenario
from amb_files.pack_file import rotor_path
from amb_sweeps.run import _request, only_writer
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore, open_sweep
from amb_sweeps.worker import PointResult, Task
from tests.support.messages import raises_naming

DESIGN = sample_plan({"Omega": np.linspace(100.0, 200.0, 24), "x.y": ["a", "b"]})


def fill(folder, group="", design=DESIGN):
    """A sweep with all its points."""
    store = SweepStore(folder, design, {"a": 1}, {}, group)
    draw = np.random.default_rng(1)
    store.add(
        [PointResult(n, "recovered", "why" * (n % 3), {"peak": draw.normal()}, 1.0 + n) for n in range(design.size)]
    )
    return folder


@pytest.mark.parametrize("unit", ["hours", "days", "seconds", "ms", "seconds since 2000-01-01"])
def test_numbers_with_a_unit_of_time_stay_numbers(tmp_path, monkeypatch, unit):
    """Before 2026, xarray made times of such numbers without being asked."""
    monkeypatch.setattr(xr, "open_zarr", partial(xr.open_zarr, decode_timedelta=True))
    fill(tmp_path, design=sample_plan({"one.t": [1.0, 2.0, 0.5]}).with_units({"one.t": unit}))
    (stored,) = open_sweep(tmp_path).coords.values()
    assert (stored.dtype, stored.attrs["units"]) == (np.float64, unit)
    np.testing.assert_array_equal(stored.values, [1.0, 2.0, 0.5])


def request(mass, guid):
    return {"rotor": {"discs": [{"mass": mass}]}, "guids": {"rotor_contact": guid}}


def test_error_names_the_changed_value_of_a_rotor(tmp_path):
    SweepStore(tmp_path, DESIGN, request(3.0, "{a}"), {})
    with pytest.raises(ValueError, match=r"rotor\.discs\[0\]\.mass: 3\.0 then, 3\.1 now") as error:
        SweepStore(tmp_path, DESIGN, request(3.1, "{b}"), {})
    assert "guid" not in str(error.value)
    with raises_naming(ValueError, "guids.rotor_contact", "{a}", "{b}", "code", "file"):
        SweepStore(tmp_path, DESIGN, request(3.0, "{b}"), {})


@pytest.mark.parametrize("name", ["bath_rig", "compressor"])
def test_the_request_of_a_sweep_has_the_content_of_its_rotor_file(name):
    task = Task(as_scenario("fig4_9", rotor=name))
    assert _request(task)["rotor"] == tomllib.loads(rotor_path(name).read_text(encoding="utf-8"))


def files(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("damage", [
    lambda content: content[: len(content) // 2],
    lambda content: b"",
    lambda content: content[:20] + bytes([content[20] ^ 4]) + content[21:],
])  # fmt: skip
@pytest.mark.parametrize(
    "name", ["peak/0.0", "outcome/0.0", "reason/0.0", "seconds/0.0", "Omega/0", "peak/.zarray", ".zgroup"]
)
def test_a_damaged_file_is_refused_on_reading_and_on_resume(tmp_path, name, damage):
    file = fill(tmp_path) / "sweep.zarr" / name
    file.write_bytes(damage(file.read_bytes()))
    before = files(tmp_path)
    for use in (open_sweep, fill):
        with pytest.raises(ValueError, match=rf"(?s){tmp_path} .*damaged, sweep\.zarr"):
            use(tmp_path)
    assert files(tmp_path) == before


@pytest.mark.parametrize("name", ["peak/0.0", "peak/.zarray", "outcome/0.0", ".zmetadata"])
def test_a_lost_file_is_damage_and_not_a_missing_value(tmp_path, name):
    (fill(tmp_path) / "sweep.zarr" / name).unlink()
    with raises_naming(ValueError, "damaged"):
        open_sweep(tmp_path)


def test_a_round_of_refinement_is_checked_separately_from_the_grid(tmp_path):
    fill(tmp_path)
    fill(tmp_path, "contact_1")
    file = tmp_path / "sweep.zarr" / "contact_1" / "peak" / "0.0"
    file.write_bytes(file.read_bytes()[:-3])
    with raises_naming(ValueError, "damaged", "sweep.zarr/contact_1/peak"):
        open_sweep(tmp_path, "contact_1")
    assert open_sweep(tmp_path).sizes == {"Omega": 24, "x.y": 2}


def test_a_boundary_is_replaced_as_a_whole(tmp_path):
    fill(tmp_path)
    store = SweepStore(tmp_path, DESIGN, {"a": 1}, {})
    for size in (2, 3):
        store.replace_group("boundary_contact", store.dataset().isel(Omega=slice(size)))
        assert open_sweep(tmp_path, "boundary_contact").sizes["Omega"] == size
    assert open_sweep(tmp_path).sizes["Omega"] == 24


def test_turned_bits_anywhere_give_the_same_numbers_or_an_error(tmp_path):
    fill(tmp_path / "whole")
    expected = open_sweep(tmp_path / "whole")
    chance = random.Random(1)
    wrong = 0
    for _ in range(60):
        shutil.copytree(tmp_path / "whole", tmp_path / "copy")
        file = chance.choice(sorted(path for path in (tmp_path / "copy").rglob("*") if path.is_file()))
        content = bytearray(file.read_bytes())
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        file.write_bytes(content)
        try:
            assert open_sweep(tmp_path / "copy").identical(expected), file
        except ValueError:
            wrong += 1
        shutil.rmtree(tmp_path / "copy")
    assert wrong > 40


@pytest.mark.parametrize("of", ["a user", "a sweep that lost its attributes", "another program", "a link"])
def test_a_folder_that_is_no_sweep_stays_untouched(tmp_path, of):
    store = tmp_path / "sweep.zarr"
    if of == "a sweep that lost its attributes":
        fill(tmp_path)
        (store / ".zattrs").unlink()
    elif of == "a link":
        (tmp_path / "elsewhere").mkdir()
        (tmp_path / "elsewhere" / "thesis.tex").write_text("years of work")
        store.symlink_to(tmp_path / "elsewhere")
    else:
        store.mkdir()
        (store / "thesis.tex").write_text("years of work")
        if of == "another program":
            (store / ".zattrs").write_text("{}")
            (store / ".zgroup").write_text(json.dumps({"zarr_format": 2}))
    (tmp_path / ".sweep.zarr.new").mkdir()
    (tmp_path / ".sweep.zarr.new" / "mine").write_text("kept")
    before = files(tmp_path)
    with raises_naming(ValueError, str(tmp_path)):
        fill(tmp_path)
    assert files(tmp_path) == before


def test_a_foreign_group_in_a_sweep_stays(tmp_path):
    fill(tmp_path)
    (tmp_path / "sweep.zarr" / "contact_1").mkdir()
    (tmp_path / "sweep.zarr" / "contact_1" / "note").write_text("kept")
    with pytest.raises(ValueError, match="no sweep"):
        fill(tmp_path, "contact_1")
    store = SweepStore(tmp_path, DESIGN, {"a": 1}, {})
    with pytest.raises(ValueError, match="no sweep"):
        store.replace_group("contact_1", store.dataset())
    assert (tmp_path / "sweep.zarr" / "contact_1" / "note").read_text() == "kept"


def test_half_written_files_of_a_killed_sweep_are_removed(tmp_path):
    fill(tmp_path)
    store = tmp_path / "sweep.zarr"
    partial = store / "peak" / f"0.{'0a' * 16}.partial"
    partial.write_bytes(b"half")
    (store / "mine.partial").write_text("kept")
    fill(tmp_path)
    assert not partial.exists()
    assert (store / "mine.partial").exists()


@pytest.mark.skipif(os.name == "nt", reason="there is no lock")
def test_a_lock_follows_no_link_and_truncates_nothing(tmp_path):
    (tmp_path / "diary").write_text("kept")
    lock = tmp_path / ".lock"
    lock.symlink_to(tmp_path / "diary")
    with pytest.raises(ValueError, match=r"\.lock"), only_writer(tmp_path):
        pass
    lock.unlink()
    os.mkfifo(lock)
    with raises_naming(ValueError, ".lock", "file"), only_writer(tmp_path):
        pass
    lock.unlink()
    lock.write_text("kept too")
    with only_writer(tmp_path), raises_naming(ValueError, "another sweep"), only_writer(tmp_path):
        pass
    assert (lock.read_text(), (tmp_path / "diary").read_text()) == ("kept too", "kept")


def link_to_another_file(array):
    content = (array / "0.0").read_bytes()
    (array / "0.0").unlink()
    (array.parents[1] / "elsewhere").write_bytes(content)
    (array / "0.0").symlink_to(array.parents[1] / "elsewhere")
    return {}


def other_codec(array):
    return {"filters": [{"id": "zlib", "level": 1}, {"id": "crc32"}]}


def array_without_chunks(array):
    (array / "0.0").unlink()
    return {"shape": [10**12, 2], "filters": None}


@pytest.mark.parametrize("forge", [link_to_another_file, other_codec, array_without_chunks])
def test_a_store_from_elsewhere_is_data_that_lie_in_it(tmp_path, forge):
    path = fill(tmp_path) / "sweep.zarr"
    described = json.loads((path / "peak" / ".zarray").read_bytes())
    index = json.loads((path / ".zmetadata").read_bytes())
    index["metadata"]["peak/.zarray"] = described | forge(path / "peak")
    (path / "peak" / ".zarray").write_text(json.dumps(index["metadata"]["peak/.zarray"]))
    (path / ".zmetadata").write_text(json.dumps(index))
    with raises_naming(ValueError, "damaged", "peak"):
        open_sweep(tmp_path)
