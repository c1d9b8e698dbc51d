"""Figures of a synthetic run with known answers, the recorder, and the file."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr

from orchestrator import plots, results
from orchestrator.recorder import Recorder

PERIOD = 0.02
SAMPLES = 100  # per cycle
CLEARANCE = 0.75e-3


def synthetic(end: int = 20, **attributes) -> xr.Dataset:
    """Orbits of 0.1 and 0.2 mm, 0.5 and 0.6 mm from the step at cycle 5 to its removal at 10, 0.3 and 0.4 mm after.

    Contact: RB1 in cycles 6 to 7, both in 7 to 7.5, RB2 in 11 to 12.
    """
    k = np.arange(end * SAMPLES + 1)
    cycle = k / SAMPLES
    loaded, after = (k >= 500) & (k < 1000), k >= 1000
    radius = {
        "mb1": np.select([loaded, after], [0.5e-3, 0.3e-3], 0.1e-3),
        "mb2": np.select([loaded, after], [0.6e-3, 0.4e-3], 0.2e-3),
    }
    state = np.select([(k >= 600) & (k < 700), (k >= 700) & (k < 750), (k >= 1100) & (k < 1200)], [1, 3, 2], 0)
    variables: dict[str, np.ndarray] = {"contact_state": state.astype(np.int32)}
    for mb, r in radius.items():
        variables[f"{mb}.x"] = r * np.cos(2 * np.pi * cycle)
        variables[f"{mb}.y"] = r * np.sin(2 * np.pi * cycle)
    variables["rb1.f_n"] = np.select([k == 650, np.isin(state, (1, 3))], [1234.5, 1000.0], 0.0)
    variables["rb2.f_n"] = np.where(np.isin(state, (2, 3)), 700.0, 0.0)
    variables["rb1.impulse"] = np.where(k == 600, 2.5, 0.0)
    variables["rb2.impulse"] = np.where(k == 700, 1.5, 0.0)
    return xr.Dataset(
        {
            f"rotor_contact.{name}": ("time", values, {"units": "1", "description": name, "causality": "output"})
            for name, values in variables.items()
        },
        {"time": ("time", cycle * PERIOD, {"units": "s"}), "cycle": ("time", cycle, {"units": "1"})},
        {
            "scenario": "synthetic",
            "flavour": "python",
            "completed": 1,
            "settling_s": 0.8,
            "simulated_s": end * PERIOD,
            "wall_s": 0.1,
            "speed_rad_s": 2 * np.pi / PERIOD,
            "step_cycle": 5.0,
            "removal_cycle": 10.0,
            "parameters": json.dumps({"rotor_contact": {f"rb{i}.clearance": CLEARANCE for i in (1, 2)}}),
            **attributes,
        },
    )


def without(dataset: xr.Dataset, *attributes: str) -> xr.Dataset:
    stripped = dataset.copy()
    stripped.attrs = {name: value for name, value in dataset.attrs.items() if name not in attributes}
    return stripped


def test_summary_of_a_known_run():
    figures = results.summary(synthetic())
    assert figures["peak_contact_force_N"] == {"rb1": 1234.5, "rb2": 700.0}
    assert figures["peak_impulse_Ns"] == {"rb1": 2.5, "rb2": 1.5}
    assert figures["contact_share"] == pytest.approx({"0": 0.7, "1": 0.2, "2": 0.0, "3": 0.1})
    assert figures["first_contact_cycle"] == pytest.approx(6.0)
    assert figures["last_contact_cycle"] == pytest.approx(11.99)
    assert figures["recovered"] is True
    assert figures["orbit_before_mm"] == pytest.approx({"mb1": 0.1, "mb2": 0.2})
    assert figures["orbit_after_mm"] == pytest.approx({"mb1": 0.3, "mb2": 0.4})
    assert figures["simulated_s"] == pytest.approx(0.4)
    assert figures["real_time_factor"] == pytest.approx(4.0)
    assert figures["flavour"] == "python"
    json.dumps(figures, allow_nan=False)


def test_share_reaches_to_the_end_without_a_removal():
    share = results.contact_share(without(synthetic(15), "removal_cycle"))
    assert share["2"] == pytest.approx(100 / 1001)
    assert sum(share.values()) == pytest.approx(1.0)


def test_share_spans_the_whole_run_without_a_step():
    share = results.contact_share(without(synthetic(10), "step_cycle", "removal_cycle"))
    assert share["1"] == pytest.approx(100 / 1001)


@pytest.mark.parametrize(("end", "expected"), [(20, True), (17, True), (16, False), (12, False)])
def test_recovered_means_free_for_the_last_five_cycles(end, expected):
    assert results.recovered(synthetic(end)) is expected


def test_a_run_that_ends_within_five_cycles_of_the_last_contact_is_not_recovered():
    _, last = results.contact_cycles(synthetic())
    assert results.recovered(synthetic(last + 4.9)) is False
    assert results.recovered(synthetic(last + 5.1)) is True


def test_a_rotor_that_never_touched_counts_as_recovered():
    assert results.recovered(synthetic(4)) is True


def test_an_impact_between_samples_counts_as_contact():
    dataset = synthetic()
    dataset["rotor_contact.rb2.impulse"][1801] = 0.01
    assert results.contact_cycles(dataset)[1] == pytest.approx(18.01)
    assert results.recovered(dataset) is False


def test_no_contact_has_no_first_and_last_cycle():
    assert results.contact_cycles(synthetic(5)) == (None, None)


def test_settling_is_left_out_of_the_figures():
    dataset = synthetic()
    early = dataset.assign_coords(cycle=dataset["cycle"] - 8.0)  # the contacts of cycles 6 to 7.5 are settling now
    assert results.peak(early, "rb1.f_n") == 0.0
    assert results.contact_cycles(early)[0] == pytest.approx(3.0)


def test_orbit_before_needs_a_step():
    assert results.orbit_before(without(synthetic(), "step_cycle")) == {"mb1": None, "mb2": None}


def test_figures_survive_missing_variables_and_an_empty_record():
    dataset = synthetic().drop_vars(["rotor_contact.contact_state", "rotor_contact.rb1.f_n", "rotor_contact.mb1.x"])
    figures = results.summary(dataset)
    assert figures["recovered"] is None
    assert figures["peak_contact_force_N"]["rb1"] is None
    assert figures["orbit_after_mm"] == {"mb1": None, "mb2": pytest.approx(0.4)}
    empty = results.summary(synthetic().isel(time=slice(0, 0)).assign_attrs(wall_s=0.0))
    assert empty["real_time_factor"] is None
    assert empty["first_contact_cycle"] is None


def test_netcdf_round_trip_keeps_data_and_figures(tmp_path):
    dataset = synthetic()
    results.save(dataset, tmp_path / "result.nc")
    again = results.load(tmp_path / "result.nc")
    xr.testing.assert_identical(again, dataset)
    assert results.summary(again) == results.summary(dataset)
    assert [p.name for p in tmp_path.iterdir()] == ["result.nc"]


def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path):
    target = tmp_path / "summary.json"
    target.write_text("old")

    def write(path):
        path.write_text("ne")
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        results.write_atomically(target, write)
    assert [p.name for p in tmp_path.iterdir()] == ["summary.json"]
    assert target.read_text() == "old"


@pytest.mark.parametrize("left_out", [(), ("removal_cycle",), ("step_cycle", "removal_cycle")])
def test_every_figure_is_drawn_from_the_data_set_alone(tmp_path, left_out):
    paths = plots.draw_all(without(synthetic(), *left_out), tmp_path)
    assert [p.name for p in paths] == ["orbits.png", "displacement.png", "contact.png"]
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in paths)


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_the_shortest_runs_can_be_drawn(tmp_path, samples):
    plots.draw_all(synthetic().isel(time=slice(0, samples)), tmp_path)


def test_phases_share_their_ends_so_that_lines_join():
    parts = plots.phases(synthetic())
    assert [name for name, _, _ in parts] == ["before the step", "with the added unbalance", "after its removal"]
    covered = sum(within.astype(int) for _, _, within in parts)
    assert covered.min() == 1
    assert np.flatnonzero(covered == 2).tolist() == [500, 1000]


def test_recorder_decimates_and_skips_settling():
    recorder = Recorder([2, 0], first=0, every=3)
    for n in range(-5, 8):
        recorder(n, np.array([n, 0.0, 10.0 * n]))
    assert recorder.points.tolist() == [0, 3, 6]
    assert recorder.table.tolist() == [[0, 0], [30, 3], [60, 6]]
    assert recorder.reached == 7


def test_recorder_grows_with_the_run():
    recorder = Recorder([0], first=0)
    for n in range(5000):
        recorder(n, np.array([float(n)]))
    assert recorder.table[:, 0].tolist() == list(range(5000))
