"""Where an FMU finds its data: every form of location that hosts pass, and those that are refused."""

import base64
import shutil
import sys

import pytest
from raw import ERROR, OK, WARNING, Library

from tests.support.messages import assert_names

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="paths of Windows are tested under wine")


@pytest.fixture(scope="module")
def folder(library2, tmp_path_factory):
    """Resources in a folder whose name must be encoded in a URI, and which cannot be written."""
    place = tmp_path_factory.mktemp("a b") / "Größe 100% #1? €😀" / "resources"
    shutil.copytree(library2.path.parents[2] / "resources", place)
    place.chmod(0o555)
    yield place
    place.chmod(0o755)


@pytest.mark.parametrize(
    "form",
    [
        "{uri}",
        "{uri}/",
        "file:{encoded}",
        "file://localhost{encoded}",
        "FILE://LocalHost{encoded}//",
        "file://{path}",
        "file:{hexadecimal}",
        "{path}",
        "{path}/",
        "{path}\\",
        "{path}/../resources",
    ],
)
def test_every_form_of_a_location_leads_to_the_data(library2, folder, form):
    encoded = folder.as_uri().removeprefix("file://")
    hexadecimal = "".join(f"%{byte:02{'xX'[k % 2]}}" for k, byte in enumerate(str(folder).encode()))
    location = form.format(uri=folder.as_uri(), encoded=encoded, path=folder, hexadecimal=f"/{hexadecimal}")
    with library2.instantiate(resources=location) as fmu:
        assert fmu.pointer, fmu.log
        fmu.begin(u=1.0)
        assert fmu.step(0) == OK


def test_a_path_may_be_relative_to_the_working_folder(library2, folder, monkeypatch):
    monkeypatch.chdir(folder.parent)
    for location in ("resources", "./resources/", "file:resources"):
        with library2.instantiate(resources=location) as fmu:
            assert fmu.pointer, fmu.log


def test_the_data_may_be_given_in_memory_instead_of_a_file(library_of):
    library = library_of("native")
    text = base64.b64encode((library.path.parents[2] / "resources" / "model.bin").read_bytes()).decode()
    for location in (f"data:;base64,{text}", f"data:application/octet-stream;base64,{text.rstrip('=')}"):
        with library.instantiate(resources=location).begin(u=1.0) as fmu:
            assert fmu.step(0) == OK


@pytest.fixture(scope="module")
def alone(library2, tmp_path_factory):
    """The same library without resources beside it."""
    folder = tmp_path_factory.mktemp("alone") / "fmu"
    shutil.copytree(library2.path.parents[2], folder, ignore=shutil.ignore_patterns("resources"))
    return Library(folder)


@pytest.mark.parametrize("location", [None, "", "/nowhere", "file:///nowhere", "file://server/x", "https://server/x"])
def test_the_data_beside_the_library_replace_a_wrong_location(library2, location):
    """FMUSDK and others do not pass where they have unpacked the FMU."""
    beside = library2.path.parents[2] / "resources"
    with library2.instantiate(resources=location) as fmu:
        values = "NULL" if location is None else location
        sentence = f"there are no resources at {values}; those beside the library are used, {beside}"
        assert fmu.log == [(WARNING, "logStatusWarning", sentence)]
        fmu.begin(u=1.0)
        assert fmu.step(0) == OK
        assert fmu.get("y") != [0.0]
    with library2.instantiate(resources=location, logging=0) as fmu:
        assert (fmu.pointer is not None, fmu.log) == (True, [])


@pytest.mark.parametrize(
    ("location", "facts"),
    [
        (None, ("resource location",)),
        ("", ("resource location",)),
        ("/nowhere", ("/nowhere/model.bin", "No such file or directory")),
        ("file:///nowhere%20else/", ("/nowhere else/model.bin", "No such file or directory")),
        ("file:///100%/%zz/%4/%4z", ("/100%%/%%zz/%%4/%%4z/model.bin", "No such file or directory")),
        ("file://server/share", ("file://server/share",)),
        ("file://localhost.local/share", ("file://localhost.local/share",)),
        ("c:/nowhere", ("c:/nowhere/model.bin", "No such file or directory")),
        ("file://c:/nowhere", ("c:/nowhere/model.bin", "No such file or directory")),
        ("here:nowhere", ("here:nowhere/model.bin", "No such file or directory")),
        ("/", ("/model.bin", "No such file or directory")),
        ("https://server/share", ("https://server/share",)),
        ("/" + 10000 * "x", ("cannot read",)),
        ("data:,;base64,AAAA", ("data URI", "data:;base64")),
        ("data:,abc", ("data URI", "data:;base64")),
        ("data:;base64,AB!D", ("data URI", "base64", "character 16")),
        ("data:;base64,AB=D", ("data URI", "base64", "character 16")),
        ("data:;base64,", ("resources/model.bin", "no data")),
    ],
)
def test_a_location_without_data_is_refused_with_the_reason(alone, location, facts):
    fmu = alone.instantiate(resources=location, logging=0)
    assert fmu.pointer is None
    assert [entry[:2] for entry in fmu.log] == [(ERROR, "logStatusError")]
    assert_names(fmu.log[0][2], *facts)


@pytest.mark.parametrize(
    ("content", "facts"),
    [(slice(-1), ("size", "bytes")), (bytes(1 << 18), ("no data",)), (None, ("Is a directory",))],
    ids=["short", "long", "folder"],
)
def test_a_file_or_folder_in_place_of_the_data_is_refused(library2, alone, tmp_path, content, facts):
    file = tmp_path / "model.bin"
    if content is None:
        file.mkdir()
    else:
        whole = (library2.path.parents[2] / "resources" / "model.bin").read_bytes()
        file.write_bytes(content if isinstance(content, bytes) else whole[content])
    fmu = (alone if content is None else library2).instantiate(resources=str(tmp_path))
    assert fmu.pointer is None
    assert_names(fmu.log[0][2], "model.bin" if content is None else "resources/model.bin", *facts)
