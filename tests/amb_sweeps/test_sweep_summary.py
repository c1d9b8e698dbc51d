"""The printed summary of a sweep, and the distribution of its largest contact force over the phase of an event."""

import math
from dataclasses import replace

import numpy as np
import pytest
from drawn import cut_texts

import amb_cosim
from amb_cosim.presentation.descriptions import common_words
from amb_sweeps.commands import _request
from amb_sweeps.figures import draw_sweep
from amb_sweeps.maps import draw_map
from amb_sweeps.panels import value_text
from amb_sweeps.phases import distribution, draw_distribution, draw_phases
from amb_sweeps.run import Sweep
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore
from amb_sweeps.worker import PointResult
from tests.amb_sweeps.conftest import filled, refined
from tests.support.messages import assert_names

RPM = np.pi / 30.0
CONTROLS = {"PID": {}, "ROLAC": {"a.on": True}}


def force(settings):
    return {"averaged_contact_force": 100.0 * settings["a.x"] / (2.0 if settings.get("a.on") else 1.0)}


def test_averaged_force_is_listed_before_the_peak_with_its_site(tmp_path):
    """The average over 1 ms is the number that converges; the peak of another point may be larger."""

    def forces(settings):
        averaged, peak = 20.0 * settings["a.x"], 900.0 / settings["a.x"]
        return {
            "averaged_contact_force": averaged,
            "averaged_contact_force.rb1": 1.0,
            "averaged_contact_force.rb2": averaged,
            "peak_contact_force": peak,
            "peak_contact_force.rb1": peak,
        }

    (line,) = filled(tmp_path, {"a.x": "1:3:3"}, forces).summary.splitlines()
    averaged, peak = line.split("; ")[1:]
    assert_names(averaged, "1 ms", "60 N", "RB2", "x = 3")
    assert_names(peak, "between impacts", "900 N", "RB1", "x = 1")


def test_a_summary_has_its_forces_and_speeds_in_the_chosen_units(tmp_path):
    """The largest force, 900 N at 3000 rpm, is 0.9 kN at 50 Hz."""
    vary = {"Omega": "1000 rpm:3000 rpm:3"}
    swept = filled(tmp_path, vary, lambda settings: {"peak_contact_force": 0.3 * float(settings["Omega"].split()[0])})
    assert_names(swept.summary, "900 N", "3000 rpm")
    with amb_cosim.units("kN", "Hz"):
        assert_names(swept.summary, "0.9 kN", "50 Hz")


def test_a_summary_counts_outcomes_shared_steps_and_reasons(tmp_path):
    design = sample_plan({"control": CONTROLS, "a.x": "1:4:4"})
    store = SweepStore(tmp_path, design, {"scenario": {"name": "made up"}}, {})
    store.add([PointResult(n, "failed", "no power") for n in (0, 1)])
    store.add([PointResult(n, "trapped", "", {"m": math.nan, "shared": 0.25 * (n - 5)}) for n in (5, 6, 7)])
    assert Sweep(tmp_path, design).summary.splitlines() == [
        "PID: 4 runs, 2 failed, 2 not run yet",
        "ROLAC: 4 runs, 3 trapped, 1 not run yet",
        "25 % of all steps were shared with earlier points",
        "2 of the runs: no power",
    ]


def test_a_summary_counts_the_runs_that_end_before_an_event(tmp_path):
    def metrics(settings):
        return {"late_events": 2.0} if settings["a.x"] < 3.0 else {"contact": 0.0}

    _, line = filled(tmp_path / "late", {"a.x": "1:4:4"}, metrics).summary.splitlines()
    assert_names(line, "2 of 4", "event", "no effect")
    assert len(filled(tmp_path / "none", {"a.x": "3:4:2"}, metrics).summary.splitlines()) == 1


def test_a_summary_compares_the_boundary_with_a_grid_as_fine(tmp_path):
    swept = filled(tmp_path, {"control": CONTROLS, "a.x": "0:1:5"}, lambda s: {"recovered": float(s["a.x"] < 0.3)})
    refinement, _ = refined(swept, 0.01, lambda settings: settings["a.x"] < 0.3)
    refinement.save(SweepStore(swept.folder, swept.design, {"scenario": {"name": "made up"}}, {}))
    halvings = math.ceil(math.log2(0.25 / 0.01))
    assert swept.summary.splitlines()[-1] == (
        f"boundary of recovered: 2 points, to within 1 % of an axis; {2 * halvings} additional runs, "
        f"{10 + 2 * halvings} in total; an equally fine grid would take 202 runs"
    )


def test_a_distribution_has_the_quantiles_over_all_other_axes(tmp_path):
    vary = {"control": CONTROLS, "step.cycle": "5:6:3", "a.x": "1:5:5"}
    swept = filled(tmp_path, vary, lambda s: {"averaged_contact_force": s["step.cycle"] * s["a.x"]})
    result = distribution(swept.dataset.sel(control="PID"), "step.cycle")
    np.testing.assert_allclose(result, np.outer([1.0, 2.0, 3.0, 4.0, 5.0], [5.0, 5.5, 6.0]))
    figure = draw_distribution(swept, swept.dataset, "step.cycle")
    assert [ax.get_title() for ax in figure.axes] == ["PID", "ROLAC"]
    assert figure.axes[0].get_xlabel() == "phase of the step (deg)"
    assert_names(figure.legends[0].get_title().get_text(), "over all values", "x")
    figure.draw_without_rendering()
    widths = [ax.get_position().width for ax in figure.axes]
    assert sum(widths) > 0.5, "most of the figure is its panels"
    assert draw_sweep(swept) == ["outcome.png", "averaged_contact_force.png", "phase.png"]


def test_a_sampled_phase_is_drawn_and_a_sweep_without_one_is_not(tmp_path):
    sampled = filled(tmp_path / "sampled", {"step.cycle": "5:6", "a.x": "1:2"}, force, "lhs:8")
    assert draw_phases(sampled) == ["phase.png"]
    assert draw_phases(filled(tmp_path / "other", {"a.x": "1:2:2"}, force)) == []


def test_maps_describe_their_axes_and_count_failed_runs(tmp_path):
    """A name without a description stays; the largest unbalance failed."""
    vary = {"Omega": "200:260 rad/s:3", "step.rotor_contact.turbine.u": "5 g.mm:60 g.mm:3", "a.aware": ["true"]}
    design = sample_plan(vary).with_units({"Omega": "rad/s"})
    unbalance = {"step.rotor_contact.turbine.u": "Unbalance of turbine, from the step on (3.20); a fixed one"}
    words = {"descriptions": unbalance | {"a.aware": "Adapts to contact; else to orbits"}}
    store = SweepStore(tmp_path, design, {"scenario": {"name": "made up"}}, words)
    ends = ["recovered"] * 8 + ["failed"]
    store.add([PointResult(n, ends[n], "", {"contact_share": 0.1 * n} if n < 8 else {}) for n in range(9)])
    swept = Sweep(tmp_path, design)
    figure = draw_map(swept, swept.dataset, "contact_share")
    assert figure.axes[0].get_xlabel() == "Omega (rpm)"
    lowest, highest = figure.axes[0].get_xlim()
    assert lowest < 200.0 / RPM < 260.0 / RPM < highest < 300.0 / RPM
    with amb_cosim.units("rad/s"):
        assert draw_map(swept, swept.dataset, "contact_share").axes[0].get_xlabel() == "Omega (rad/s)"
    assert figure.axes[0].get_ylabel().replace("\n", " ") == "Unbalance of turbine, from the step on (g mm)"
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["failed: 1 of 9"]
    assert figure.axes[0].get_title() == "Adapts to contact: true"


@pytest.mark.parametrize("speeds", ["14 Hz:18 Hz:3", "840 rpm:1080 rpm:3", "87.9646 rad/s:113.097 rad/s:3"])
def test_a_map_has_speeds_in_rpm_whatever_the_unit_of_their_range(speeds, tmp_path):
    """The data set keeps the unit of the range."""
    swept = filled(tmp_path, {"Omega": speeds, "a.x": "1:2:2"}, force)
    (panel, *_) = draw_map(swept, swept.dataset, "averaged_contact_force").axes
    (lowest, highest), half = panel.get_xlim(), 60.0  # of a cell
    assert panel.get_xlabel() == "Omega (rpm)"
    np.testing.assert_allclose((lowest + half, highest - half), (840.0, 1080.0), rtol=1e-5)
    assert swept.dataset["Omega"].attrs["units"] == speeds.split(":")[1].split()[1]


def test_a_map_has_no_boundary_next_to_points_without_contact(tmp_path):
    """Without a disturbance they neither recovered nor failed to; a boundary needs points of both kinds."""
    vary = {"a.x": "0:1:2", "a.y": "0:1:2"}
    for ends, drawn in (((np.nan, np.nan), 0), ((np.nan, 1.0), 0), ((0.0, 1.0), 1)):
        folder = tmp_path / f"{ends[0]}_{ends[1]}"
        swept = filled(folder, vary, lambda s, ends=ends: {"recovered": ends[int(s["a.x"])]})
        legends = draw_map(swept, swept.dataset, "outcome").legends
        assert sum("boundary" in text.get_text() for legend in legends for text in legend.texts) == drawn


def test_the_refined_boundary_is_where_the_map_has_it(tmp_path):
    """Its points are stored without units."""
    vary = {"Omega": "10 Hz:20 Hz:3", "a.x": "0:1:3"}
    swept = filled(tmp_path, vary, lambda s: {"recovered": float(s["a.x"] < 0.3)})
    refinement, _ = refined(swept, 0.1, lambda settings: settings["a.x"] < 0.3)
    refinement.save(SweepStore(swept.folder, swept.design, {"scenario": {"name": "made up"}}, {}))
    (panel, *_) = draw_map(replace(swept, boundary="recovered"), swept.dataset, "outcome").axes
    (line,) = panel.lines
    assert sorted({*line.get_xdata()}) == [600.0, 900.0, 1200.0]


def test_variables_of_one_axis_are_described_by_their_common_words():
    assert (
        common_words(["Coefficient of friction at SEAL", "Coefficient of friction at SHROUD"])
        == "Coefficient of friction"
    )
    assert common_words(["Unbalance of turbine; a fixed one"]) == "Unbalance of turbine; a fixed one"
    assert common_words(["Clearance at SEAL", "Gap of north"]) == common_words([]) == ""


def test_two_outcomes_have_two_colours_and_the_title_is_the_description(tmp_path):
    """No colour bar: of its numbers only 0 and 1 occur."""
    swept = filled(tmp_path, {"a.x": "1:3:3", "a.y": "1:2:2"}, lambda s: {"rolling": float(s["a.x"] > 1.0)})
    figure = draw_map(swept, swept.dataset, "rolling")
    (panel,) = figure.axes
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["does not roll", "rolls"]
    drawn = {tuple(colour) for colour in panel.collections[0].to_rgba(swept.dataset["rolling"].values.ravel())}
    assert drawn == {handle.get_facecolor() for handle in figure.legends[0].get_patches()}
    assert figure.get_suptitle() == "Variations of made up"
    words = "Rolling of the rotor over speed and friction, " * 6
    figure = draw_map(replace(swept, description=words), swept.dataset, "rolling")
    assert figure.get_suptitle().split() == words.split()
    assert not cut_texts(figure)
    legends = [legend.get_window_extent() for legend in figure.legends]
    assert not any(legend.overlaps(figure._suptitle.get_window_extent()) for legend in legends)


def test_a_title_says_that_the_scenario_is_varied_and_not_how_it_ends(tmp_path):
    """At the speed of the scenario lies a single point of a map over speed."""
    design = sample_plan({"Omega": "200:260 rad/s:3"})
    about = {"name": "rub", "description": "a step at 260 rad/s: the rotor recovers"}
    swept = Sweep(tmp_path, design)
    SweepStore(tmp_path, design, {"scenario": about}, {}).add([PointResult(0, "recovered", "", {})])
    assert_names(swept.title, "rub", "Variations")
    assert "recovers" not in swept.title
    assert f"{260.0 / RPM:.0f} rpm" in replace(swept, description="Maps at 260 rad/s").title


def test_ready_sweep_has_its_description_in_the_title():
    options = {"vary": {}, "set": {}, "rotor": None, "receptances": None, "flavour": "native"}
    assert "friction" in _request("rolling", options)[1]
    assert _request("fig4_9", options)[1] == ""


def test_units_in_figures_have_spaces_between_their_factors():
    assert value_text("rotor_contact.d1.u", 25.0, "g.m") == "u = 25 g m"
    assert value_text("Omega", 100.0 * np.pi, "rad/s") == "Omega = 3000 rpm"
    assert value_text("rotor_contact.d1.u", 25.0, "um", "Orbit") == "Orbit: 25 \N{MICRO SIGN}m"
    assert value_text("rotor_contact.rb1.mu", 0.2, "1") == "mu = 0.2"
