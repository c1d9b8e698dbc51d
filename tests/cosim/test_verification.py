"""`verify` reports equality only for compared results of the FMU: inputs and held values do not count."""

import pytest

import amb_cosim
from tests.cosim.test_variables import DESCRIPTIONS, SOURCE
from tests.support.changed_archive import changed_archive
from tests.support.messages import assert_names
from tests.support.reference_results import FOLDER, table, verified_with

GOOD, END = 0, 1  # of the input `what` of arrays3.c
EXPERIMENT = """<Experiments><Experiment name="one" stopTime="0.4" stepSize="0.1">
<Stimuli type="text/csv" source="in.csv"/><References type="text/csv" source="out.csv"/></Experiment></Experiments>"""


@pytest.fixture
def verified(arrays3_fmu, tmp_path):
    """`verified(rows, columns, what)`: the result of reference rows from 0 s in steps of 0.1 s."""

    def verify(rows, columns="sum", what=GOOD, stimulus=()):
        more = f",{','.join(stimulus)}" if stimulus else ""
        inputs = "\n".join([f"time,what{more}", *(f"{t},{what}{',3 4' if stimulus else ''}" for t in (0.0, 0.4))])
        files = {"one.exp": EXPERIMENT, "in.csv": inputs, "out.csv": table(columns, rows)}
        return verified_with(arrays3_fmu, tmp_path / "Arrays3.fmu", files)

    return verify


@pytest.fixture
def texts_fmu(fmu_from_c, tmp_path):
    """`texts_fmu(columns, rows, version=3)`: the result of reference rows of the FMU of `texts.c`."""

    def verify(columns, rows, version=3):
        fmu = fmu_from_c(SOURCE, DESCRIPTIONS[version], version)
        return verified_with(fmu, tmp_path / "Texts.fmu", {"out.csv": table(columns, rows)})

    return verify


@pytest.mark.parametrize(("value", "is_equal"), [("91,0", True), ("91,5", False)])
def test_references_of_a_german_spreadsheet_are_compared(verified, tmp_path, value, is_equal):
    """The sum of the outputs, 91, in a file with semicolons, decimal commas and UTF-16."""
    verified([0.0])
    rows = ["time;sum", "0,0;0,0", *(f"0,{k};{value}" for k in range(1, 5))]
    path = tmp_path / "Arrays3.fmu"
    changed_archive(path, path, {f"{FOLDER}/out.csv": "\r\n".join(rows).encode("utf-16")})
    (item,) = amb_cosim.verify(path)
    assert (item.is_equal, item.n_values) == (is_equal, 5)


def test_an_fmu_that_ends_before_its_references_is_not_equal(verified):
    """Its last value, held, would be that of all later rows."""
    item = verified([0.0, 91.0, 91.0, 91.0, 91.0], what=END)
    assert not item.is_equal
    assert_names(item, "NOT equal", "ended", "0.1 s", "0.4 s")


def test_references_as_short_as_the_run_of_an_fmu_that_ends_are_compared(verified):
    assert verified([0.0, 91.0], what=END).is_equal


def test_an_input_is_not_compared_with_its_own_stimulus(verified):
    item = verified(["0.0,3 4", "91.0,3 4"], "sum,Float64.in", stimulus=("Float64.in",))
    assert (item.is_equal, item.n_values) == (True, 2)
    assert_names(item, "not compared", "Float64.in (an input)")
    alone = verified(["3 4", "3 4"], "Float64.in", stimulus=("Float64.in",))
    assert not alone.is_equal
    assert_names(alone, "not run", "no numbers", "Float64.in (an input)")


def test_outputs_that_cannot_be_compared_are_listed(texts_fmu):
    item = texts_fmu("y,blob,lines", ["1004.0,00,a", "1004.0,00,a"])
    assert (item.is_equal, item.n_values) == (True, 2)
    assert_names(item, "not compared", "blob (of type Binary)", "lines (of type String, an array)")


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(("columns", "cell"), [("y,said", "1004.0,{}"), ("said", "{}")])
def test_texts_are_compared_at_every_time(texts_fmu, version, columns, cell):
    """The output `said` is the string that the FMU received, here its start value."""
    rows = [cell.format(text) for text in ("none", "none", "none")]
    item = texts_fmu(columns, rows, version)
    assert (item.is_equal, item.n_values) == (True, 3 + 3 * ("y" in columns))
    other = texts_fmu(columns, [*rows[:2], cell.format("some")], version)
    assert not other.is_equal
    assert_names(other, "NOT equal", "said = 'none'", "'some'", "0.2 s")


def test_references_at_the_start_alone_verify_nothing(verified):
    item = verified([0.0])
    assert not item.is_equal
    assert_names(item, "not run", "no time after", "0 s")
