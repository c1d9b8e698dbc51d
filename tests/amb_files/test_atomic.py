"""Files and folders appear whole or not at all."""

from __future__ import annotations

import pytest

from amb_files.atomic import create_atomically, write_atomically


def fail(path):
    (path / "half" if path.is_dir() else path).write_text("half")
    raise RuntimeError("stopped")


def test_file_is_replaced_whole_or_stays(tmp_path):
    path = tmp_path / "a.txt"
    write_atomically(path, lambda p: p.write_text("old"))
    with pytest.raises(RuntimeError):
        write_atomically(path, fail)
    assert path.read_text() == "old"
    write_atomically(path, lambda p: p.write_text("new"))
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_folder_is_created_whole_or_not_at_all(tmp_path):
    folder = tmp_path / "a"
    with pytest.raises(RuntimeError):
        create_atomically(folder, fail)
    assert not list(tmp_path.iterdir())
    create_atomically(folder, lambda p: (p / "x").write_text("first"))
    create_atomically(folder, fail)
    assert (folder / "x").read_text() == "first"


def test_folder_of_the_first_of_two_processes_stays(tmp_path):
    folder = tmp_path / "a"

    def overtaken(stage):
        (stage / "x").write_text("second")
        create_atomically(folder, lambda p: (p / "x").write_text("first"))

    create_atomically(folder, overtaken)
    assert (folder / "x").read_text() == "first"
    assert list(tmp_path.iterdir()) == [folder]
