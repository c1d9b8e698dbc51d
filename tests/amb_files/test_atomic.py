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


@pytest.mark.parametrize("steps", [1, 3])
@pytest.mark.parametrize("exists", [True, False], ids=["a file", "no file"])
@pytest.mark.parametrize("is_absolute", [True, False])
def test_a_link_stays_and_the_file_behind_it_is_written(tmp_path, steps, exists, is_absolute):
    """Over several links and folders; an editor creates a missing file."""
    (tmp_path / "data").mkdir()
    target = tmp_path / "data" / "target"
    if exists:
        target.write_text("old")
    before = target if is_absolute else Path("data/target")
    for k in range(steps):
        (tmp_path / f"link{k}").symlink_to(before)
        before = tmp_path / f"link{k}" if is_absolute else Path(f"link{k}")
    link = tmp_path / f"link{steps - 1}"
    check_writable(link, is_folder=False)
    write_file(link, "new")
    assert link.is_symlink()
    assert target.read_text() == "new"
    assert not target.is_symlink()
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["data", *(f"link{k}" for k in range(steps)), "target"]


def test_a_link_in_a_linked_folder_leads_from_where_it_lies(tmp_path):
    (tmp_path / "far" / "away").mkdir(parents=True)
    (tmp_path / "far" / "away" / "link").symlink_to("../target")
    (tmp_path / "near").symlink_to("far/away")
    write_file(tmp_path / "near" / "link", "new")
    assert (tmp_path / "far" / "target").read_text() == "new"
    assert [path.name for path in tmp_path.glob("target")] == []


@pytest.mark.parametrize("target", ["missing/file", "link", "circle", "folder"])
def test_a_link_to_no_possible_file_is_an_error_and_stays(tmp_path, target):
    (tmp_path / "folder").mkdir()
    (tmp_path / "circle").symlink_to("link")
    link = tmp_path / "link"
    link.symlink_to(target)
    with raises_naming(ValueError, str(link)):
        check_writable(link, is_folder=False)
    with raises_naming(OSError, str(link)):
        write_file(link, "new")
    assert str(link.readlink()) == target
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["circle", "folder", "link"]


@pytest.mark.skipif(sys.platform == "win32", reason="files have no such permissions there")
@pytest.mark.parametrize("mode", [0o600, 0o664, 0o755])
def test_a_file_keeps_its_permissions(tmp_path, mode):
    (tmp_path / "file").write_text("old")
    (tmp_path / "file").chmod(mode)
    (tmp_path / "link").symlink_to("file")
    for name in ("file", "link"):
        write_file(tmp_path / name, "new")
        assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == mode
    plain = tmp_path / "plain"
    plain.write_text("")
    write_file(tmp_path / "new", "new")
    assert (tmp_path / "new").stat().st_mode == plain.stat().st_mode


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="needs two users")
def test_a_file_keeps_its_owner(tmp_path):
    (tmp_path / "file").write_text("old")
    os.chown(tmp_path / "file", 65534, 65534)
    write_file(tmp_path / "file", "new")
    status = (tmp_path / "file").stat()
    assert (status.st_uid, status.st_gid) == (65534, 65534)


def test_a_file_that_is_only_readable_is_refused(tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.write_text("old")
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path) != file)
    with raises_naming(ValueError, str(file)):
        check_writable(file, is_folder=False)
    with raises_naming(PermissionError, str(file)):
        write_file(file, "new")
    assert file.read_text() == "old"


def test_a_link_to_a_missing_folder_is_no_output_folder(tmp_path):
    (tmp_path / "out").symlink_to("missing")
    with raises_naming(ValueError, str(tmp_path / "out"), "missing"):
        check_writable(tmp_path / "out", is_folder=True)


@pytest.mark.skipif(sys.platform != "linux", reason="open files have paths on Linux")
def test_standard_output_that_is_a_file_gets_the_bytes(tmp_path, run_python):
    def write(folder: str) -> None:
        import os
        import sys
        from pathlib import Path

        from amb_files.atomic import write_file

        sys.stdout.flush()
        before, link = os.dup(1), Path(folder, "link")
        with Path(folder, "printed").open("w") as file:
            os.dup2(file.fileno(), 1)
        link.symlink_to("/dev/stdout")
        write_file(link, "first ")
        write_file(Path("/dev/stdout"), "second ")
        os.write(1, b"third")
        os.dup2(before, 1)

    run_python(write, folder=tmp_path)
    assert (tmp_path / "printed").read_text() == "first second third"
    assert (tmp_path / "link").is_symlink()


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
    (tmp_path / "old.json").touch()
    for name, target in (("link.json", "old.json"), ("to_folder.json", "result.nc"), ("to_pipe.json", "summary.json")):
        (tmp_path / name).symlink_to(target)
    check_writable(tmp_path, is_folder=True, files=("old.json", "link.json", "new.json"))
    for name in ("result.nc", "summary.json", "to_folder.json", "to_pipe.json"):
        with raises_naming(ValueError, name):
            check_writable(tmp_path, is_folder=True, files=("old.json", name))


def test_a_file_of_a_program_follows_links_to_files_only(tmp_path):
    """The user named the folder, not a device behind a link in it."""
    (tmp_path / "folder").mkdir()
    for name, target in (("result.nc", tmp_path / "elsewhere"), ("null", Path(os.devnull))):
        (tmp_path / "folder" / name).symlink_to(target)
    write_file(plain_file(tmp_path / "folder", "result.nc"), "new")
    assert (tmp_path / "folder" / "result.nc").is_symlink()
    assert (tmp_path / "elsewhere").read_text() == "new"
    with raises_naming(OSError, str(tmp_path / "folder" / "null")):
        plain_file(tmp_path / "folder", "null")
