"""Files and folders are written completely or not at all."""

import errno
import os
import stat
import sys
import threading
from pathlib import Path

import pytest

from amb_files.atomic import check_writable, create_atomically, plain_file, write_atomically, write_file
from amb_files.temporary_folders import temporary_folder
from tests.support.messages import raises_naming


def fail(path):
    (path / "half" if path.is_dir() else path).write_text("half")
    raise RuntimeError("stopped")


def test_file_is_replaced_as_a_whole_or_not_at_all(tmp_path):
    path = tmp_path / "a.txt"
    write_atomically(path, lambda p: p.write_text("old"))
    with pytest.raises(RuntimeError):
        write_atomically(path, fail)
    assert path.read_text() == "old"
    write_atomically(path, lambda p: p.write_text("new"))
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(("content", "stored"), [("Lüfter\n", b"L\xc3\xbcfter\n"), (b"\x00\xff", b"\x00\xff")])
@pytest.mark.skipif(sys.platform == "win32", reason="lines end otherwise there")
def test_text_is_written_as_utf_8_and_bytes_unchanged(tmp_path, content, stored):
    write_file(tmp_path / "file", content)
    assert [path.read_bytes() for path in tmp_path.iterdir()] == [stored]


def test_folder_is_created_as_a_whole_or_not_at_all(tmp_path):
    folder = tmp_path / "a"
    with pytest.raises(RuntimeError):
        create_atomically(folder, fail)
    assert not list(tmp_path.iterdir())
    create_atomically(folder, lambda p: (p / "x").write_text("first"))
    create_atomically(folder, fail)
    assert (folder / "x").read_text() == "first"


def test_the_first_of_two_processes_creates_the_folder(tmp_path):
    folder = tmp_path / "a"

    def overtaken(stage):
        (stage / "x").write_text("second")
        assert not folder.exists(), "a folder appears whole"
        create_atomically(folder, lambda p: (p / "x").write_text("first"))

    create_atomically(folder, overtaken)
    assert (folder / "x").read_text() == "first"
    assert list(tmp_path.iterdir()) == [folder]


def test_bytes_are_written_to_a_pipe_and_a_device(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    got = []
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()))
    reader.start()
    write_atomically(pipe, lambda p: p.write_text("text"))
    reader.join(10.0)
    assert got == [b"text"]
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    null = tmp_path / "null"
    null.symlink_to(os.devnull)
    write_atomically(null, lambda p: p.write_text("text"))
    assert null.is_symlink()
    assert null.is_char_device()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["null", "pipe"]


@pytest.mark.parametrize("target", ["target", "missing", "missing/target", "link", "folder"])
def test_a_link_is_replaced_and_its_target_stays(tmp_path, target):
    """It may have come with the folder of somebody else."""
    (tmp_path / "target").write_text("mine")
    (tmp_path / "folder").mkdir()
    link = tmp_path / "link"
    link.symlink_to(target)
    write_file(link, "new")
    assert not link.is_symlink()
    assert link.read_text() == "new"
    assert (tmp_path / "target").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["folder", "link", "target"]


def test_a_link_is_writable_wherever_it_leads(tmp_path):
    (tmp_path / "link").symlink_to("missing/file")
    check_writable(tmp_path / "link", is_folder=False)


def test_temporary_files_of_a_killed_process_are_removed_by_the_next(tmp_path, run_python):
    def killed(folder: str) -> None:
        import os
        from pathlib import Path

        from amb_files.atomic import write_atomically

        if os.fork() == 0:
            write_atomically(Path(folder, "a"), lambda p: (p.write_text("half"), os._exit(0)))
        os.wait()

    run_python(killed, folder=tmp_path)
    (left,) = tmp_path.iterdir()
    assert (left / "a").read_text() == "half"

    def beside_another(path):
        path.write_text("whole")
        write_atomically(tmp_path / "b", lambda p: p.write_text("whole"))

    write_atomically(tmp_path / "a", beside_another)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "whole", "b": "whole"}


@pytest.mark.parametrize("name", [".amb-cosim-mine", ".amb-cosim-0123456789abcdef-0123456789abcdef"])
def test_a_folder_that_only_resembles_a_temporary_one_stays(tmp_path, name):
    mine = tmp_path / name
    mine.mkdir()
    (mine / "note").write_text("kept")
    write_atomically(tmp_path / "a", lambda p: p.write_text("whole"))
    assert (mine / "note").read_text() == "kept"


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs two users")
def test_a_folder_of_another_user_stays(tmp_path):
    with temporary_folder(tmp_path) as used:
        name = used.name
    (tmp_path / name).mkdir()
    os.chown(tmp_path / name, 65534, 65534)
    write_atomically(tmp_path / "a", lambda p: p.write_text("whole"))
    assert (tmp_path / name).is_dir()
    os.chown(tmp_path / name, 0, 0)
    write_atomically(tmp_path / "a", lambda p: p.write_text("whole"))
    assert not (tmp_path / name).exists()


def test_an_error_names_the_file_to_be_written(tmp_path):
    def full(path):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), *([str(path)] if path.is_dir() else []))

    for write in (write_atomically, create_atomically):
        with raises_naming(OSError, "No space left") as error:
            write(tmp_path / "a", full)
        assert error.value.filename == str(tmp_path / "a")


def test_a_device_is_writable_although_its_folder_is_not(tmp_path):
    check_writable(Path(os.devnull), is_folder=False)
    with raises_naming(ValueError, str(tmp_path / "no")):
        check_writable(tmp_path / "no" / "file", is_folder=False)
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
def test_a_folder_where_a_folder_or_pipe_takes_the_place_of_a_file_is_refused(tmp_path):
    (tmp_path / "result.nc").mkdir()
    os.mkfifo(tmp_path / "summary.json")  # opening it would wait for a reader
    (tmp_path / "link.json").symlink_to(tmp_path / "result.nc")  # is replaced
    (tmp_path / "old.json").touch()
    check_writable(tmp_path, is_folder=True, files=("old.json", "link.json", "new.json"))
    for name in ("result.nc", "summary.json"):
        with raises_naming(ValueError, name):
            check_writable(tmp_path, is_folder=True, files=("old.json", name))


def test_a_file_of_a_program_replaces_a_link_and_keeps_its_target(tmp_path):
    """Whoever gave the folder may have put the link there; the user named the folder alone."""
    (tmp_path / "target").write_text("mine")
    (tmp_path / "folder").mkdir()
    for name in ("result.nc", "dangling"):
        (tmp_path / "folder" / name).symlink_to(tmp_path / ("target" if name == "result.nc" else "nothing"))
        write_file(plain_file(tmp_path / "folder", name), "new")
        assert not (tmp_path / "folder" / name).is_symlink()
        assert (tmp_path / "folder" / name).read_text() == "new"
    assert (tmp_path / "target").read_text() == "mine"
    assert not (tmp_path / "nothing").exists()
