"""Damaged FMUs are refused with one message before any part is loaded, and damaged caches are rebuilt."""

import zipfile
from pathlib import Path

import fmpy
import pytest
from slow import slow_but_first

from amb_cosim.cosim.fmu import fmus
from amb_cosim.cosim.system.assembly import assemble
from amb_cosim.cosim.system.system import Component, System
from amb_files.archive import archive_of, write_archive
from tests.support.messages import raises_naming

LIBRARY = f"binaries/{fmpy.platform}/Mass{fmpy.sharedLibraryExtension}"
DESCRIPTION = "modelDescription.xml"


@pytest.fixture
def valid_fmu(foreign_fmus) -> Path:
    return foreign_fmus / "Mass.fmu"


def entries(archive: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(archive) as content:
        return {name: content.read(name) for name in content.namelist()}


def assembled(path: Path) -> None:
    assemble(System("one", "", (Component("mass", str(path)),), ()))


# Changes of the bytes of an archive that begins with the entry `modelDescription.xml`.


def with_a_bit_flipped(data: bytearray) -> None:
    data[200] ^= 1


def encrypted(data: bytearray) -> None:
    data[data.index(b"PK\x01\x02") + 8] |= 1


def packed_in_an_unknown_way(data: bytearray) -> None:
    data[data.index(b"PK\x01\x02") + 10] = 77


def cut(data: bytearray) -> None:
    del data[len(data) // 2 :]


def unchanged(data: bytearray) -> None:
    """Leave the bytes as they are."""


@pytest.mark.parametrize(("damage", "added", "facts"), [
    (with_a_bit_flipped, {}, ("FMU",)),
    (encrypted, {}, ("modelDescription.xml", "encrypted")),
    (packed_in_an_unknown_way, {}, ("compression",)),
    (cut, {}, ("zip archive",)),
    (unchanged, {"resources/zeros": 300}, ("{size} MB", "<= 256 MB")),
    (unchanged, {"../elsewhere": 0}, ("../elsewhere",)),
])  # fmt: skip
def test_a_damaged_archive_is_refused(valid_fmu, tmp_path, damage, added, facts):
    """`added` are entries of so many MB of zeros."""
    path = tmp_path / "mass.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, content in sorted(entries(valid_fmu).items(), key=lambda entry: entry[0] != DESCRIPTION):
            archive.writestr(name, content)
        for name, length in added.items():
            with archive.open(name, "w") as zeros:
                for _ in range(length):
                    zeros.write(bytes(2**20))
        size = round(sum(entry.file_size for entry in archive.infolist()) / 2**20)
    data = bytearray(path.read_bytes())
    damage(data)
    path.write_bytes(data)
    with raises_naming(ValueError, str(path), *(fact.format(size=size) for fact in facts)):
        assembled(path)


def test_entries_that_occur_twice_are_read_if_they_are_equal(valid_fmu, tmp_path):
    """As those in `extra` of Roberts.fmu, one of the Reference-FMUs."""
    path = write_archive(tmp_path / "mass.fmu", archive_of(entries(valid_fmu) | {"extra/note": b"same"}))
    for content, added in ((b"same", "read"), (b"other", "refused")):
        with zipfile.ZipFile(path, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
            archive.writestr("extra/note", content)
        if added == "read":
            assembled(path)
    with raises_naming(ValueError, "two", "extra/note"):
        assembled(path)


@pytest.mark.parametrize(("changes", "facts"), [
    ({LIBRARY: None}, ("library Mass", f"{fmpy.platform}")),
    ({"resources/slavemodule.txt": None}, ("resources/slavemodule.txt",)),
    ({"resources/mass.py": None}, ("resources/mass.py",)),
    ({DESCRIPTION: None}, ("readable",)),
    ({DESCRIPTION: lambda content: content[:-100]}, ("readable",)),
    ({DESCRIPTION: lambda content: content.replace(b"guid=", b"name=")}, ("modelDescription.xml", "'guid'")),
    ({DESCRIPTION: lambda content: content.replace(b'Identifier="', b'Identifier="../')}, ("name in C",)),
])  # fmt: skip
@pytest.mark.skipif(fmpy.system != "linux", reason="the checks of libraries are of those of Linux")
def test_an_fmu_with_damaged_content_is_refused_before_it_is_loaded(valid_fmu, tmp_path, changes, facts):
    content = entries(valid_fmu)
    for name, change in changes.items():
        before = content.pop(name)
        if change is not None:
            content[name] = change(before)
    path = write_archive(tmp_path / "mass.fmu", archive_of(content))
    with raises_naming(ValueError, *facts) as error:
        assembled(path)
    assert str(error.value).startswith(f"mass: {path}")
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("damage", slow_but_first(["changed", "cut", "missing", "no archive"]))
def test_a_damaged_entry_of_the_cache_is_rebuilt(tmp_path, monkeypatch, valid_fmu, damage):
    """The FMU of flavour python, which is made without a compiler."""
    monkeypatch.setattr("platformdirs.user_cache_path", lambda name, *_, **__: tmp_path / name)
    values = (lambda: fmus.ensure_built("amb_actuator", "python"), lambda: fmus.provide(str(valid_fmu)))
    for get in values[: 1 if damage == "no archive" else 2]:
        fmu = get()
        file = fmu.path if damage == "no archive" else fmu.folder / DESCRIPTION
        before = file.read_bytes()
        if damage == "changed":
            file.write_bytes(before.replace(b"e", b"f", 1))
        elif damage == "cut":
            file.write_bytes(before[:-100])
        else:
            file.unlink()
        assert get() == fmu
        assert file.read_bytes() == before
    assert not list((tmp_path / "amb-cosim").glob(".amb-cosim-*"))


def test_a_temporary_cache_replaces_one_that_cannot_be_written(run_python, tmp_path):
    def without_home() -> list:
        import os

        os.environ.update(HOME="/dev/null", XDG_CACHE_HOME="/dev/null")
        from amb_cosim.cosim.fmu.fmus import ensure_built

        return [str(ensure_built("amb_actuator", "python").folder), os.environ["TMPDIR"]]

    folder, temporary = map(Path, run_python(without_home))
    assert folder.is_relative_to(temporary)
    assert not folder.exists()
    assert not list(temporary.glob(".amb-cosim-*"))
