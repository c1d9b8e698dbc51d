"""Variables of a run as figures and files, and the last turns with keyphasor marks."""

import csv
import re

import numpy as np
import pytest
import xarray as xr
from scipy.io import loadmat

from amb_cosim import simulate
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.plots import Plots
from amb_cosim.results.plots.turns import whirl_direction
from amb_cosim.results.result import Result
from amb_cosim.results.selection import mat_name, select, to_mat
from tests.support.messages import assert_names, raises_naming


@pytest.fixture
def result(synthetic) -> Result:
    dataset = synthetic(outcome='["completed", 0.4, null, ""]')
    for name in ("mb1.x", "mb1.y", "mb2.x", "mb2.y"):
        dataset[f"rotor_contact.{name}"].attrs["units"] = "m"
    for name in ("rb1.f_n", "rb2.f_n"):
        dataset[f"rotor_contact.{name}"].attrs["units"] = "N"
    return Result(dataset, Outcome("completed", 0.4))


def test_variables_of_a_unit_share_a_panel(result):
    figure = result.plot("mb1.x", "mb1.y", "rb?.f_n", "contact_state")
    displacement, force, state = figure.axes
    assert (displacement.get_ylabel(), force.get_ylabel()) == ("mm", "kN")
    assert [line.get_label() for line in displacement.lines[:2]] == ["mb1.x", "mb1.y"]
    assert np.nanmax(displacement.lines[0].get_ydata()) == pytest.approx(0.5)
    assert np.nanmax(force.lines[0].get_ydata()) == pytest.approx(1.2345)
    assert state.get_title("left").startswith("rotor_contact.contact_state: contact_state")


def test_values_with_names_have_ticks_with_these_names_and_numbers_a_label(result):
    """Enumerations with the same names share a panel; Booleans and numbers have others."""
    result.dataset["rotor_contact.rb1.mode"].attrs |= {
        "flag_values": [0, 1, 2],
        "flag_meanings": "free sliding rolling",
    }
    result.dataset["rotor_contact.rb2.mode"].attrs |= result.dataset["rotor_contact.rb1.mode"].attrs
    samples = result.dataset.sizes["time"]
    result.dataset["rotor_contact.rb1.passed"] = ("time", np.zeros(samples, np.int8), {"units": "1"})
    result.dataset["rotor_contact.rb1.number"] = ("time", np.ones(samples, np.int32), {"units": "1"})
    figure = result.plot("rb?.mode", "rb1.passed", "contact_state", "rb1.number")
    ticks = [[text.get_text() for text in panel.get_yticklabels()] for panel in figure.axes]
    assert ticks[:3] == [["free", "sliding", "rolling"], ["false", "true"], ["none", "RB1", "RB2", "both"]]
    assert len(figure.axes[0].lines[:2]) == 2
    assert [panel.get_ylabel() for panel in figure.axes] == ["", "", "", "dimensionless"]


def test_a_panel_of_several_variables_says_what_they_have_in_common(result):
    for name, axis in (("mb1.x", "x"), ("mb1.y", "y")):
        result.dataset[f"rotor_contact.{name}"].attrs["description"] = f"Displacement at MB1 in {axis}"
    result.dataset["rotor_contact.mb2.x"].attrs["description"] = "Position at MB2"
    titles = [result.plot("mb1.x", name).axes[0].get_title("left") for name in ("mb1.y", "mb2.x")]
    assert titles == ["Displacement at MB1", "2 variables of rotor_contact"]


def test_traces_span_the_chosen_interval(result):
    (panel,) = result.plot("mb1.x", begin="cycle 4", until="0.2 s").axes
    assert panel.get_xlim() == pytest.approx((4.0, 10.0))
    assert len(panel.lines[0].get_xdata()) == 601


@pytest.mark.parametrize(
    ("arguments", "options", "facts"),
    [
        (("mb1.z",), {}, ("'mb1.z'",)),
        (("rotor_contact.mb1.z",), {}, ("'rotor_contact.mb1.z'", "rotor_contact.mb1.y")),
        (("mb1.x",), {"begin": "9 s"}, ("9 s", "0 s to 0.4 s")),
        ((), {}, ("variable",)),
    ],
)
def test_selection_that_is_empty_is_refused(result, arguments, options, facts):
    with raises_naming(ValueError, *facts):
        result.plot(*arguments, **options)


def test_csv_has_names_units_and_full_precision(result, tmp_path):
    path = result.to_csv(tmp_path / "run.csv", "mb1.x", until="cycle 1")
    with path.open(encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    assert heading == ["time [s]", "rotor_contact.mb1.x [m]"]
    values = np.array(rows, np.float64)
    np.testing.assert_array_equal(values[:, 1], result.dataset["rotor_contact.mb1.x"].values[: len(rows)])
    assert len(rows) == 101


def test_mat_has_variables_units_and_time(result, tmp_path):
    content = loadmat(result.to_mat(tmp_path / "run.mat", "mb1.*"), simplify_cells=True)
    np.testing.assert_array_equal(content["rotor_contact_mb1_x"], result.dataset["rotor_contact.mb1.x"].values)
    np.testing.assert_array_equal(content["time"], result.dataset["time"].values)
    assert content["units"]["rotor_contact_mb1_y"] == "m"


NAMES = ["1motor.x", "_a.b", "µ.x", "end", "é", "a.b"]


def test_any_name_becomes_one_that_matlab_allows():
    names = [mat_name(name) for name in NAMES]
    assert names == ["x_1motor_x", "x__a_b", "x___x", "x_end", "x__", "a_b"]
    assert all(re.fullmatch("[A-Za-z][A-Za-z0-9_]*", name) for name in names)


def test_no_variable_is_lost_in_a_mat_file(tmp_path):
    """SciPy left out names that begin with an underscore or a digit, and `units` was lost to the table of units."""
    table = {name: ("time", np.arange(3.0), {"units": "m"}) for name in NAMES}
    dataset = xr.Dataset(table, {"time": ("time", np.arange(3.0), {"units": "s"})})
    to_mat(select(dataset), tmp_path / "run.mat")
    content = loadmat(tmp_path / "run.mat", simplify_cells=True)
    assert {name for name in content if name[:2] != "__"} == {"time", "units", *map(mat_name, NAMES)}
    assert set(content["units"]) == {"time", *map(mat_name, NAMES)}
    dataset["units"] = ("time", np.arange(3.0))
    with raises_naming(ValueError, "units", "MAT"):
        to_mat(select(dataset), tmp_path / "run.mat")


def test_names_that_coincide_in_a_mat_file_are_refused(result, tmp_path):
    result.dataset["rotor_contact.mb1_x"] = result.dataset["rotor_contact.mb1.x"]
    with raises_naming(ValueError, "rotor_contact_mb1_x"):
        result.to_mat(tmp_path / "run.mat")
    assert not (tmp_path / "run.mat").exists()


ANGLE = np.linspace(0.0, 2.0 * np.pi, 200)


@pytest.mark.parametrize(
    ("sense", "flatness", "expected"),
    [(1.0, 1.0, "forward whirl"), (-1.0, 1.0, "backward whirl"), (1.0, 0.01, "to and fro")],
)
def test_direction_of_whirl_is_the_sign_of_the_area(sense, flatness, expected):
    assert whirl_direction(np.array([3.0 + np.cos(ANGLE), flatness * np.sin(sense * ANGLE)])) == expected


def test_keyphasor_marks_each_revolution(result):
    """An orbit of 0.3 mm at the rotor's speed: at each turn it is where x is largest."""
    panel = result.plot.turns().axes[0]
    orbit, marks = panel.lines[:2]
    assert np.hypot(*orbit.get_data()) == pytest.approx(0.3)
    x, y = marks.get_data()
    assert len(x) == 4
    assert x == pytest.approx(0.3)
    assert y == pytest.approx(0.0, abs=1e-9)
    assert any(text.get_text().startswith("forward whirl, 1x 0.3 mm") for text in panel.texts)


@pytest.mark.parametrize(
    ("suffix", "begin"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".csv", b'"time'), (".mat", b"MATLAB 5")]
)
def test_plot_writes_the_format_of_the_suffix(result, tmp_path, runner, suffix, begin):
    folder = result.save(tmp_path / "run", plots=False)
    file = tmp_path / f"traces{suffix}"
    done = runner("plot", str(folder), "mb1.x", "-o", str(file))
    assert done.exit_code == 0, done.stderr
    assert file.read_bytes().startswith(begin)


def test_a_range_of_times_since_1970_has_no_further_samples():
    times = 1.7e9 + 1e-4 * np.arange(100)
    dataset = xr.Dataset({"a.b": ("time", np.arange(100.0))}, {"time": ("time", times)})
    assert select(dataset, begin=float(times[50]), until=float(times[60])).values("a.b").tolist() == [*range(50, 61)]


def test_a_thinned_record_of_a_system_draws_steps_where_it_has_them(tmp_path):
    """Without a scenario there are no cycles, and only outputs with a rule over a step are recorded at every step."""
    experiment = '[experiment]\ncommunication_step = "0.25 ms"\nstop_time = "10 ms"\nrecord.every = 10\n'
    (tmp_path / "thin.toml").write_text(f'base = "levitated"\n{experiment}', encoding="utf-8")
    draw = Plots(simulate(str(tmp_path / "thin.toml")).signals)
    force, motion = draw("rb1.f_n_peak").axes[0], draw("mb1.x").axes[0]
    assert [len(panel.lines[0].get_xdata()) for panel in (force, motion)] == [41, 5]
    assert not force.texts
    assert_names(motion.texts[0].get_text(), "10 steps")
