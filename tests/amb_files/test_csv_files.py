"""Tables that tools and spreadsheets of other countries write."""

import numpy as np
import pytest

from amb_files import csv_files
from amb_files.csv_files import read_csv, read_numbers
from tests.support.messages import raises_naming

TABLE = (["time", "y"], [["0", "-1.5e-3"], ["0.25", "20"]])


@pytest.fixture
def read(tmp_path):
    """`read(text, encoding)`: headings and rows of a file with that text."""

    def write_and_read(text, encoding="utf-8"):
        (tmp_path / "a.csv").write_text(text, encoding=encoding, newline="")
        return read_csv(tmp_path / "a.csv", "table a.csv")

    return write_and_read


@pytest.mark.parametrize(
    "text",
    [
        "time,y\n0,-1.5e-3\n0.25,20\n",
        "time;y\r\n0;-1,5e-3\r\n0,25;20\r\n",
        "time;y\n0;-1.5e-3\n0.25;20\n",
        "time\ty\n0\t-1,5e-3\n0,25\t20\n",
        "time\ty\n0\t-1.5e-3\n0.25\t20\n",
        '"time","y"\n"0","-1,5e-3"\n"0,25","20"\n',
        "sep=;\r\ntime;y\r\n0;-1,5e-3\r\n0,25;20\r\n",
        "sep=|\ntime|y\n0|-1,5e-3\n0,25|20\n",
        "time;y;\n0;-1,5e-3;\n0,25;20;\n",
        " time ; y\n\n0;-1,5e-3\n;\n0,25;20\n\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_table_is_the_same_in_every_form(read, text, encoding):
    assert read(text, encoding) == TABLE


def test_separators_within_names_do_not_split_columns(read):
    assert read("time;u[1,2]\n0;1,5\n") == (["time", "u[1,2]"], [["0", "1.5"]])
    assert read('time,"u[1,2]"\n0,1.5\n') == (["time", "u[1,2]"], [["0", "1.5"]])
    assert read("time,a;b\n0,1.5\n") == (["time", "a;b"], [["0", "1.5"]])


def test_arrays_and_texts_keep_their_form(read):
    assert read("time;u;s\n0,5;1,5 -2 ,25;a, b\n")[1] == [["0.5", "1.5 -2 .25", "a, b"]]
    assert read('time,s\n0.5,"a, b"\n')[1] == [["0.5", "a, b"]]


def test_three_decimals_are_read_if_another_number_shows_the_comma(read):
    assert read("time;y\n0,5;1,500\n")[1] == [["0.5", "1.500"]]
    assert read("time;y\n0,125;1\n")[1] == [["0.125", "1"]]


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("time;y\n0;1,500\n1;2,250\n", ("1,500", "1500", "1.500")),
        ("time;y\n0,5;1.5\n", ("1.5", "0,5")),
        ("time;y\n0,5;1.234,5\n", ("1.234,5", "thousands")),
        ("time;y\n0;1,234,567\n", ("1,234,567", "thousands")),
        ("time;y\n0,5;1'234,5\n", ("1'234,5", "thousands")),
        ("time,y\n0,5,1,5\n", ("row 2", "it has 4", "decimal commas", "semicolons")),
        ("time\n0,5\n", ("row 2", "it has 2", "decimal commas")),
        ("time;y\n0;1\n1\n", ("row 3", "it has 1", "semicolons", "2 values")),
        ("time;y;y\n0;1;2\n", ("two columns", "'y'")),
        ("time;y\n", ("row",)),
        ("", ("row",)),
    ],
)
def test_an_ambiguous_table_is_refused_with_its_cause(read, text, facts):
    with raises_naming(ValueError, "table a.csv", *facts):
        read(text)


@pytest.mark.parametrize("encoding", ["cp1252", "utf-16-le"])
def test_another_encoding_is_refused_with_advice(read, encoding):
    with raises_naming(ValueError, "table a.csv", "save", "UTF-8"):
        read("time;\u00b5m\n0;1\n", encoding)


def by_cells(headings, rows):
    return np.array(rows, np.float64)


def not_by_cells(headings, rows):
    pytest.fail("a table of plain numbers is read cell by cell, which takes ten times as long")


@pytest.mark.parametrize(
    "text",
    [
        "time,y\n0,-1.5e-3\n0.25,20\n",
        "time;y\r\n0;-1,5e-3\r\n0,25;20\r\n",
        "time\ty\n0\t-1.5e-3\n\n0.25\t20",
        "# a\n# time, y\n0,-1.5e-3\n0.25, 20\n",
        "sep=|\ntime|y\n0|-1,5e-3\n0,25|20\n",
    ],
)
def test_numbers_of_a_table_are_read_at_once_as_cell_by_cell(read, tmp_path, text):
    (tmp_path / "n.csv").write_text(text, newline="")
    headings, numbers = read_numbers(tmp_path / "n.csv", "table", not_by_cells)
    assert (headings, numbers.tolist()) == (["time", "y"], [[0.0, -1.5e-3], [0.25, 20.0]])
    assert by_cells(*read(text)).tolist() == numbers.tolist()


@pytest.mark.parametrize(
    "text",
    [
        *("time;y\n0;1,500\n1;2,250\n", "time;y\n0,5;1.5\n", "time,y\n0,5,1,5\n", "time;y\n0;1\n1\n"),
        *("time,y,y\n0,1,2\n", "time,y\n", "time;y\n0,5;1,234,5\n"),
    ],
)
def test_numbers_of_an_ambiguous_table_are_refused_as_its_cells(read, tmp_path, text):
    with pytest.raises(ValueError, match=r"table a\.csv") as expected:
        read(text)
    with pytest.raises(ValueError, match=r"table a\.csv") as found:
        read_numbers(tmp_path / "a.csv", "table a.csv", by_cells)
    assert str(found.value) == str(expected.value)


@pytest.mark.parametrize("cell", ['"1"', "1_0", "\u0663", "0x1F", "", "1d0", "x"])
def test_cells_that_are_no_plain_numbers_are_left_to_their_reader(tmp_path, cell, monkeypatch):
    (tmp_path / "n.csv").write_text(f"time,y\n0,1\n1,{cell}\n", encoding="utf-8")
    _, numbers = read_numbers(tmp_path / "n.csv", "table", lambda _, rows: np.array([[len(rows)]]))
    assert numbers.tolist() == [[2]]
    monkeypatch.setattr(csv_files, "MOST_CELLS", 10)
    with raises_naming(ValueError, "table", "number", "quotes", "MB"):
        read_numbers(tmp_path / "n.csv", "table", by_cells)
