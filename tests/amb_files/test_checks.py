"""Checks of values and names."""

from amb_files.checks import repeated


def test_repeated_names_are_found_in_one_pass():
    """Counting each name in the list would take minutes here."""
    names = [f"name {k}" for k in range(200_000)]
    assert repeated([*names, "b", "a", "a", "b", "a"]) == ["b", "a"]
    assert repeated(names) == []
