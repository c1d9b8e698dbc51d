"""Names with wildcards, and indices in brackets, which are none."""

import pytest

from amb_files.wildcards import is_pattern, matches, matching_names


@pytest.mark.parametrize(
    ("pattern", "found"),
    [
        ("b.i_[xy]", ["b.i_x", "b.i_y"]),
        ("b.?_x", ["b.i_x"]),
        ("u[1]", ["u[1]"]),
        ("u[*]", ["u[1]", "u[12]"]),
        ("u[?]", ["u[1]"]),
        ("g[*,1]", ["g[1,1]", "g[2,1]"]),
        ("u1", ["u1"]),
        ("*", ["b.i_x", "b.i_y", "u[1]", "u[12]", "g[1,1]", "g[2,1]", "u1"]),
    ],
)
def test_brackets_with_numbers_match_themselves(pattern, found):
    names = ["b.i_x", "b.i_y", "u[1]", "u[12]", "g[1,1]", "g[2,1]", "u1"]
    assert matching_names(names, pattern) == found
    assert all(matches(name, pattern) for name in found)


@pytest.mark.parametrize(("name", "answer"), [("u[1]", False), ("g[2,3]", False), ("u[*]", True), ("i_[xy]", True)])
def test_an_index_makes_no_pattern(name, answer):
    assert is_pattern(name) is answer
