"""The cache of built and unpacked FMUs has a size limit, and removes only its entries."""

import os
import time
import zipfile

import pytest

from amb_cosim.cosim.building import cache
from amb_files.archive import unpack
from tests.support.messages import raises_naming

DAY = 24 * 3600.0


@pytest.fixture
def filled(tmp_path, monkeypatch):
    """A cache with four entries of 1000 bytes, unused for 4, 3, 2 and 0 days, and two things of somebody else's."""
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_, **__: tmp_path)
    for k, days in enumerate((4, 3, 2, 0)):
        folder = tmp_path / f"model{k}-{k:032x}"
        (folder / "extracted").mkdir(parents=True)
        (folder / "extracted" / "file").write_bytes(bytes(1000))
        os.utime(folder, (time.time() - days * DAY,) * 2)
    (tmp_path / "engines").mkdir()
    os.utime(tmp_path / "engines", (0.0, 0.0))
    (tmp_path / "mine").mkdir()
    (tmp_path / "notes.txt").write_text("kept")
    return tmp_path


def names(folder):
    return sorted(path.name.partition("-")[0] for path in folder.iterdir() if path.name != cache.MEASURED)


def archive(folder, count=1):
    path = folder.parent / "new.fmu"
    with zipfile.ZipFile(path, "w") as content:
        for k in range(count):
            content.writestr(f"entry{k}", bytes(1000))
    return path


def test_a_new_entry_evicts_the_least_recently_used(filled, monkeypatch):
    monkeypatch.setattr(cache, "LIMIT", 3000)
    cache.note_use(filled / f"model0-{0:032x}", is_new=False)
    new = cache.unpacked(archive(filled), "an FMU")
    assert names(filled) == ["engines", "mine", "model0", "model3", "new", "notes.txt"]
    assert cache.unpacked(archive(filled), "an FMU") == new


@pytest.mark.parametrize("name", ["my model.fmu", "100 % Läufer #2.fmu", "model.fmu"])
def test_uri_of_an_unpacked_fmu_has_no_escaped_characters(filled, name):
    """Some FMUs open their resources by the text of the URI: those of OpenModelica up to 1.18."""
    home = cache.unpacked(archive(filled).rename(filled.parent / name), "an FMU")
    assert "%" not in home.as_uri()
    assert home.parent == filled
    assert home in [entry.path for entry in cache.cache_entries()]


def test_an_fmu_is_new_until_it_is_loaded_and_again_once_it_was_removed(filled):
    home = cache.unpacked(archive(filled), "an FMU")
    cache.unpacked(archive(filled), "an FMU")
    assert cache.is_first_loading(home)
    assert not cache.is_first_loading(home)
    cache.remove_entries()
    assert names(filled) == ["mine", "notes.txt"]
    assert cache.is_first_loading(cache.unpacked(archive(filled), "an FMU"))


def test_entries_used_today_stay_even_above_the_limit(filled, monkeypatch):
    monkeypatch.setattr(cache, "LIMIT", 1)
    cache.unpacked(archive(filled), "an FMU")
    assert names(filled) == ["engines", "mine", "model3", "new", "notes.txt"]


def test_the_cache_is_measured_once_an_hour(filled, monkeypatch):
    """Thousands of entries take a second, which each new FMU would cost."""
    measured = []
    monkeypatch.setattr(cache, "remove_entries", lambda **_: measured.append(time.time()))
    for _ in range(3):
        cache.note_use(filled / f"model0-{0:032x}", is_new=True)
    assert len(measured) == 1
    os.utime(filled / cache.MEASURED, (time.time() - 3700.0,) * 2)
    cache.note_use(filled / f"model0-{0:032x}", is_new=True)
    assert len(measured) == 2


def test_the_command_shows_and_clears(filled, runner):
    listed = runner("cache").stdout
    assert [line.split()[-1].partition("-")[0] for line in listed.splitlines()[:-1]] == [
        "engines",
        *(f"model{k}" for k in range(4)),
    ]
    assert f"5 in {filled}" in listed
    assert runner("cache", "--clear").stdout.startswith("removed 5 in")
    assert names(filled) == ["mine", "notes.txt"]


def test_an_archive_of_very_many_entries_is_refused(tmp_path):
    path = archive(tmp_path / "folder", 10_001)
    with raises_naming(ValueError, "10001 entries", "<= 10000"):
        unpack(path, tmp_path / "there", "the archive")
