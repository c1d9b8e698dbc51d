"""FMUs carry an experiment with reference results in the layout of FMI-LS-REF, and `verify` runs and compares it."""

import csv
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from host_marks import in_host

import amb_cosim
from amb_cosim.commands.cli import main
from amb_cosim.cosim.errors import ProcessFailed
from fmi_export.building.experiment import experiment_files
from fmi_export.model import with_starts
from tests.support.changed_archive import changed_archive, with_text
from tests.support.messages import assert_names, raises_naming
from tests.support.reference_results import verify_here

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"


@pytest.fixture(scope="module")
def moving(lag):
    """The lag with a voltage at its input, so that its output moves."""
    return with_starts(lag, {"u": 1.0})


@pytest.fixture
def changed(native, moving, tmp_path):
    """`changed(file, old, new)`: the lag's FMU with a text of its experiment replaced, or without the file."""

    def change(name, old="", new=None):
        files = native(moving), tmp_path / "changed.fmu"
        entry = f"{FOLDER}/{name}"
        return changed_archive(*files, {entry: None}) if new is None else with_text(*files, entry, old, new)

    return change


def references(path):
    with zipfile.ZipFile(path) as fmu:
        return list(csv.DictReader(fmu.read(f"{FOLDER}/references.csv").decode().splitlines()))


def test_manifest_and_experiment_follow_the_standard(native, moving):
    with zipfile.ZipFile(native(moving)) as fmu:
        manifest = ElementTree.fromstring(fmu.read(f"{FOLDER}/fmi-ls-manifest.xml"))
        experiments = ElementTree.fromstring(fmu.read(f"{FOLDER}/smoke_test.exp"))
        assert "amb-cosim verify probe_lag.fmu" in fmu.read("documentation/fmi-ls-ref.txt").decode()
        size = sum(entry.compress_size for entry in fmu.infolist() if "ls-ref" in entry.filename)
    assert size < 3000, "bytes of an archive"
    space = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert (manifest.tag, manifest.get(f"{space}fmi-ls-name")) == ("fmiReferences", "org.fmi-standard.fmi-ls-ref")
    assert manifest.get(f"{space}fmi-ls-version") == "1.0.0-alpha.1"
    (related,) = manifest
    assert (related.get("role"), related.get("type")) == ("experiment/smoke-test", "application/x-ma-hs-experiments")
    assert (related.get("source"), experiments.tag) == ("smoke_test.exp", "Experiments")
    (item,) = experiments
    assert item[0].attrib == {"startTime": "0", "stopTime": "0.0025", "stepSize": "0.00025"}
    assert [e.get("source") for e in item[1:]] == ["references.csv"]


def test_a_model_without_valid_start_values_carries_no_experiment(lag, native):
    native(lag)  # builds its engine
    assert experiment_files(lag, np.zeros(1))
    assert experiment_files(with_starts(lag, {"u": 5.0}), np.zeros(1)) == {}
    assert experiment_files(replace(lag, name="no_engine"), np.zeros(1)) == {}


@in_host("FMPy", "a probe, FMI 2.0, 3.0, both flavours", "its experiment, to the last bit")
@pytest.mark.parametrize("flavour", ["native", "native 3", "python"])
def test_each_flavour_verifies_itself_to_the_last_bit(native, moving, flavour, tmp_path):
    whole = native(moving)
    if flavour == "python":
        from fmi_export.building.python_fmu import build_python_fmu

        whole = build_python_fmu(moving, np.zeros(1), tmp_path)
    (item,) = amb_cosim.verify(whole if flavour != "native 3" else native(moving, None, None, 3))
    assert (item.largest, item.is_equal, item.n_points) == (None, True, 11)
    assert_names(item, "smoke_test", "last bit")


def test_arrays_of_fmi_3_are_one_column_each(native, matrix):
    whole, alone = (references(native(matrix, None, None, fmi)) for fmi in (3, 2))
    assert whole[-1]["f"].split() == [alone[-1]["f0"], alone[-1]["f1"]]
    assert len(whole[-1]["z"].split()) == 8
    (item,) = amb_cosim.verify(native(matrix, None, None, 3))
    assert item.largest is None
    assert item.n_values > 100


def test_differences_in_last_bits_are_tolerated(changed, native, moving):
    row = references(native(moving))[4]
    name = next(name for name in row if name != "time" and float(row[name]) not in (0.0, 1.0))
    other = {**row, name: repr(float(row[name]) * (1.0 + 1e-9))}
    (item,) = amb_cosim.verify(changed("references.csv", ",".join(row.values()), ",".join(other.values())))
    assert item.is_equal
    assert (item.largest.variable, item.largest.time) == (name, 4 * 250e-6)
    assert item.largest.relative == pytest.approx(1e-9, rel=0.5)


def test_a_fault_in_the_experiment_is_reported_by_the_message_of_the_fmu(changed, native, moving):
    """As an FMU does whose host got a parameter wrong; stimuli replace what the experiment has."""
    path = changed("smoke_test.exp", "<References", '<Stimuli source="in.csv" /><References')
    with zipfile.ZipFile(path, "a") as fmu:
        fmu.writestr(f"{FOLDER}/in.csv", "time,u\n0,1\n0.001,1\n0.002,9\n0.003,9\n")
    (item,) = amb_cosim.verify(path)
    assert not item.is_equal
    assert_names(item, "NOT equal", "FMU failed", "t")
    assert "u = " in item.failure


@pytest.mark.parametrize(
    ("file", "old", "new", "facts"),
    [
        ("fmi-ls-manifest.xml", "", None, ("no experiment",)),
        ("fmi-ls-manifest.xml", "<Related", "<<Related", ("fmi-ls-manifest.xml",)),
        ("fmi-ls-manifest.xml", 'source="', 'source="../../../../../', ("file of the FMU",)),
        ("fmi-ls-manifest.xml", 'source="', 'source="https://server/', ("file of the FMU",)),
        ("smoke_test.exp", "", None, ("'smoke_test.exp'",)),
        ("smoke_test.exp", 'stopTime="', 'stopTime="x', ("stopTime", "'x0.0025'")),
        ("references.csv", "time,", "moment,", ("references.csv", "'time'")),
        ("references.csv", "level", "lvel", ("lvel",)),
        ("references.csv", "\n0.0,", "\n0.0,zero,", ("references.csv", "row 2", "7", "it has 8")),
        ("references.csv", "level", "time", ("references.csv", "two columns called 'time'")),
    ],
)
def test_error_names_the_faulty_part_of_an_experiment(changed, file, old, new, facts):
    with raises_naming(ValueError, "changed.fmu") as error:
        amb_cosim.verify(changed(file, old, new))
    assert_names(error, *facts)


def with_cell(row: int, column: int, text: str):
    """Return a change of one cell of the references."""

    def change(table: str) -> tuple[str, str]:
        line = table.splitlines()[row]
        cells = line.split(",")
        cells[column] = text
        return line, ",".join(cells)

    return change


def times_alone(table: str) -> tuple[str, str]:
    return table, "\n".join(line.split(",")[0] for line in table.splitlines())


def of_text(old: str, new: str):
    """Return a change of a text of the experiment."""
    return lambda _: (old, new)


NOTHING_COMPARED = [
    ("smoke_test.exp", of_text("TransientSimulation", "SteadyState"), ("SteadyState",)),
    ("smoke_test.exp", of_text('type="text/csv"', 'type="application/hdf5"'), ("application/hdf5",)),
    ("smoke_test.exp", of_text('stopTime="0.0025"', 'stopTime="0"'), ("stop time", "0 s")),
    *(("references.csv", with_cell(5, 1, text), ("not run", "reference", "finite")) for text in ("nan", "inf", "-inf")),
    ("references.csv", with_cell(-1, 0, "0.0031"), ("0.0031 s", "0.0025 s")),
    ("references.csv", times_alone, ("no numbers",)),
]


@pytest.mark.parametrize(("file", "change", "facts"), NOTHING_COMPARED)
def test_an_experiment_of_which_nothing_is_compared_verifies_nothing(changed, native, moving, file, change, facts):
    with zipfile.ZipFile(native(moving)) as fmu:
        text = fmu.read(f"{FOLDER}/{file}").decode()
    (item,) = verify_here(changed(file, *change(text)))
    assert not item.is_equal
    assert_names(item, *facts)


def test_a_deviating_value_is_reported_with_variable_and_time(changed, native, moving):
    """Also if the FMU states a tolerance that hides it."""
    row = references(native(moving))[4]
    path = changed("references.csv", ",".join(row.values()), ",".join({**row, "level": "0.375"}.values()))
    done = CliRunner().invoke(main, ["verify", str(path)])
    assert done.exit_code == 1
    assert_names(done.output, "smoke_test", "NOT equal", "1e-06")
    assert_names(done.output, "level", f"{float(row['level'])!r}", "0.375", "0.001 s")
    with_text(path, path, f"{FOLDER}/smoke_test.exp", "<Experiment ", '<Experiment tolerance="1e9" ')
    (item,) = amb_cosim.verify(path)
    assert not item.is_equal
    assert_names(item, "NOT equal", "0.001", "1e+09")


def test_a_name_with_a_line_break_stays_in_its_line(changed):
    path = changed("smoke_test.exp", 'name="smoke_test"', 'name="a&#10;smoke_test: equal"')
    (item,) = amb_cosim.verify(path)
    assert "\n" not in str(item)
    assert str(item).startswith("a\\nsmoke_test: equal: ")


def test_times_may_be_attributes_of_the_experiment(changed):
    """The format had them there until June 2026; examples and its text still do."""
    old = '<TransientSimulation startTime="0" stopTime="0.0025" stepSize="0.00025" />'
    begin = '<Experiment name="smoke_test" description="Constant inputs from the start values">'
    times = begin.replace("<Experiment", '<Experiment stopTime="0.0025" stepSize="0.00025"')
    (item,) = amb_cosim.verify(changed("smoke_test.exp", f"{begin}\n    {old}", times))
    assert item.largest is None


def test_an_fmu_that_crashes_ends_its_process_alone(native, moving, changed, cc, tmp_path):
    (tmp_path / "crash.c").write_text("#include <stdlib.h>\n__attribute__((constructor)) void f(void) { abort(); }\n")
    cc("-shared", "-o", tmp_path / "crash.so", tmp_path / "crash.c")
    crash = (tmp_path / "crash.so").read_bytes()
    path = changed_archive(
        native(moving), tmp_path / "crashing.fmu", {}, lambda name, old: crash if name.startswith("binaries/") else old
    )
    with raises_naming(ProcessFailed, "crashing.fmu", "SIGABRT"):
        amb_cosim.verify(path)


@pytest.mark.slow
@in_host("FMPy", "each, FMI 2.0 and 3.0", "its experiment, to the last bit")
def test_every_model_verifies_itself_to_the_last_bit(tmp_path):
    for fmi in (2, 3):
        for path in [*amb_cosim.build(tmp_path, fmi=fmi), amb_cosim.build_assembled(tmp_path, fmi=fmi)]:
            (item,) = amb_cosim.verify(path)
            assert item.largest is None, f"{path.name}: {item}"
            assert item.n_values > 400
            values = [float(x) for row in references(path) for text in row.values() for x in text.split()]
            assert len(set(values)) > 12, "they are not all zero"
