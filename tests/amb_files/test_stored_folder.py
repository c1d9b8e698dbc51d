"""Cached folders are complete, or rebuilt."""

import pytest

from amb_files.stored_folder import DIGEST, is_undamaged, keep


@pytest.fixture
def fill():
    """Writes two files; `fill.times` is how often."""

    def write(stage):
        write.times += 1
        (stage / "one").write_bytes(b"1")
        (stage / "two").write_bytes(b"2")

    write.times = 0
    return write


def test_an_undamaged_folder_is_not_rebuilt(tmp_path, fill):
    folder = tmp_path / "new" / "kept"
    assert not is_undamaged(folder)
    for _ in range(2):
        keep(folder, fill)
    assert (is_undamaged(folder), fill.times) == (True, 1)


@pytest.mark.parametrize("name", ["one", DIGEST])
@pytest.mark.parametrize(
    "damage",
    [
        *(lambda file, content=content: file.write_bytes(content) for content in (b"", b"3", b"\xff" * 64)),
        lambda file: file.unlink(),
        lambda file: file.rename(file.with_name("three")),
        lambda file: file.with_name("four").touch(),
    ],
)
def test_a_damaged_folder_is_rebuilt(tmp_path, fill, name, damage):
    folder = tmp_path / "kept"
    keep(folder, fill)
    damage(folder / name)
    assert not is_undamaged(folder)
    keep(folder, fill)
    assert (is_undamaged(folder), (folder / "one").read_bytes(), fill.times) == (True, b"1", 2)
