"""Unpacked archives are found complete, or damaged, without reading them more often than needed."""

import os
import zipfile

import pytest

from amb_files import archive as archives
from amb_files.archive import archive_of, is_unpacked, unpack


@pytest.fixture
def unpacked(tmp_path):
    archive, folder = tmp_path / "a.zip", tmp_path / "a"
    archive.write_bytes(archive_of({"x/one.txt": b"one", "two.txt": b"two"}))
    unpack(archive, folder, "an archive")
    assert is_unpacked(archive, folder)
    return archive, folder


def test_a_complete_folder_is_read_once(unpacked, monkeypatch):
    def refuse(*_):
        raise AssertionError("it was read again")

    monkeypatch.setattr(archives.zipfile, "ZipFile", refuse)
    assert is_unpacked(*unpacked)


def test_content_that_changed_since_is_found(unpacked):
    """Also with the same size, and the time of the content set back, as a copy does."""
    file = unpacked[1] / "x" / "one.txt"
    status = file.stat()
    copy = file.with_name("copy")
    copy.write_bytes(b"One")
    os.utime(copy, ns=(status.st_atime_ns, status.st_mtime_ns))
    copy.replace(file)
    assert not is_unpacked(*unpacked)
    file.write_bytes(b"one")
    assert is_unpacked(*unpacked)


def test_a_lost_file_and_another_archive_are_found(unpacked):
    archive, folder = unpacked
    with zipfile.ZipFile(archive, "a") as content:
        content.writestr("three.txt", b"three")
    assert not is_unpacked(archive, folder)
    (folder / "three.txt").write_bytes(b"three")
    assert is_unpacked(archive, folder)
    (folder / "two.txt").unlink()
    assert not is_unpacked(archive, folder)
