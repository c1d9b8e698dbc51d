"""Figures of runs that touch: scales, marked numbers, enlarged parts, titles and names of events."""

import json
import re

import numpy as np
import pytest
from drawn import cut_texts, overlapping_texts, visible_texts
from falls import CLEARANCE, LANDED, OMEGA, RELEASE, WHIRL, fall
from slow import slow_but_first

from amb_cosim.comparison.plots import overlays
from amb_cosim.presentation.style import fitted
from amb_cosim.presentation.units import force_unit
from amb_cosim.results import plots
from amb_cosim.results.contact_forces import largest_averaged_force
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.plots.axes import COLOURS, site_title
from amb_cosim.results.summary import summarise
from tests.support.messages import assert_names, raises_naming

RPM = 30.0 / np.pi


def placed(dataset, **z):
    """Return a run whose plant states the positions of its sites."""
    places = json.loads(dataset.attrs["places"]) | {"z": z}
    return dataset.assign_attrs(places=json.dumps(places))


def limits_hold(panel, value):
    low, high = panel.get_ylim()
    return low <= value <= high


@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_contact_marks_the_number_of_the_summary_on_its_own_scale(synthetic, scale):
    """RB1 has a peak of 1234.5 N and 2.5 N s of impact, RB2 is scaled: neither sets the axis of the other."""
    dataset = synthetic()
    for name in ("f_n", "impulse"):
        dataset[f"rotor_contact.rb2.{name}"] = scale * dataset[f"rotor_contact.rb2.{name}"]
    figure = plots.figure(dataset, "contact")
    numbers = summarise(dataset).averaged_contact_force
    for panel, site in zip(figure.axes, ("rb1", "rb2"), strict=False):
        size = 1e3 if "kN" in panel.get_ylabel() else 1.0
        (mark,) = [line for line in panel.lines if line.get_marker() == "o"]
        assert size * mark.get_ydata()[0] == pytest.approx(numbers[site])
        assert limits_hold(panel, mark.get_ydata()[0])
        assert panel.get_ylim()[1] * size < 4.0 * numbers[site]
        assert force_unit(numbers[site]).text(numbers[site], 3) in [text.get_text() for text in panel.texts]
    assert not overlapping_texts(figure)


def test_mean_is_thick_with_impact_impulses_and_peaks_are_pale_without(synthetic):
    figure = plots.figure(synthetic(), "contact")
    peak, mean = figure.axes[0].lines[:2]
    assert mean.get_linewidth() > 2.0 * peak.get_linewidth()
    assert mean.get_alpha() in (None, 1.0)
    assert peak.get_alpha() < 0.6
    assert np.nanmax(peak.get_ydata()) > 1.0
    of_mean, of_peak, _ = (text.get_text() for text in figure.legends[0].texts)
    assert "with impact impulses" in of_mean
    assert "without" in of_peak
    assert not cut_texts(figure)


def without_contact(dataset):
    for name in [n for n in dataset.data_vars if n.split(".")[-1] in ("f_n", "impulse", "mode", "contact_state")]:
        dataset[name] = 0 * dataset[name]
    return dataset


def test_no_contact_is_no_figure_and_no_panel(synthetic):
    dataset = without_contact(synthetic())
    assert "contact" not in plots.chosen(dataset)
    for name in ("contact", "whirl"):
        with raises_naming(ValueError, name, "touched"):
            plots.figure(dataset, name)
    dataset = synthetic()
    for name in ("f_n", "impulse", "mode"):
        dataset[f"rotor_contact.rb2.{name}"] = 0 * dataset[f"rotor_contact.rb2.{name}"]
    axes = plots.figure(dataset, "contact").axes
    assert {panel.get_title("left") for panel in axes} <= {"Retainer RB1", "In contact", "enlarged", ""}
    assert [text.get_text() for text in axes[-1].texts] == ["no contact"]


def heavy_mounts(dataset):
    """Let the contact last from the landing on, as on soft mounts: a single contact with large forces."""
    touches = dataset["time"].values > LANDED
    return dataset.assign({f"rotor_contact.{s}.f_n": ("time", np.where(touches, 900.0, 0.0)) for s in ("rb1", "rb2")})


@pytest.mark.parametrize("change", [lambda run: run, heavy_mounts], ids=["rigid", "mounts"])
@pytest.mark.parametrize("gravity", [9.81, 0.0])
def test_first_50_ms_of_a_fall_are_enlarged(change, gravity):
    dataset = change(fall(gravity))
    figure = plots.figure(dataset, "contact")
    begin, end = figure.axes[-1].get_xlim()
    assert end - begin == pytest.approx(0.05)
    assert begin < LANDED < end
    again = overlays({"a": dataset, "b": dataset.assign_attrs(scenario="b")})["contact"]
    assert again.axes[-1].get_xlim() == pytest.approx((begin, end))
    (inset,) = [inset for axes in plots.figure(dataset, "touchdown").axes for inset in axes.child_axes]
    assert inset.get_xlim() == pytest.approx((begin, end))
    displaced = plots.figure(dataset, "displacement")
    assert any(axes.get_xlim() == pytest.approx((begin, end)) for axes in displaced.axes)


def with_peak(dataset, newtons):
    """Give RB1 a peak in the first step after the landing, and no impulse of impacts, so that the mean is lower."""
    steps = dataset["time"].values
    peak = np.where(np.arange(len(steps)) == np.searchsorted(steps, LANDED) + 1, newtons, 0.0)
    mean = {"rotor_contact.rb1.f_n_mean": ("time", 0.2 * peak), "rotor_contact.rb1.f_n_peak": ("time", peak)}
    return dataset.assign(mean)


def test_peaks_beyond_the_axis_are_marked_in_the_colour_of_their_run():
    """The whole run shows twice the mean; the enlarged first impacts show the peak of five times the mean."""
    low, high = with_peak(fall(), 1000.0), with_peak(fall(), 9000.0)
    alone, compared = plots.figure(high, "contact"), overlays({"low": low, "high": high})["contact"]
    for figure, colour in ((alone, COLOURS[0]), (compared, COLOURS[1])):
        whole, enlarged = figure.axes[:2]
        marks = [line.get_color() for line in whole.lines if line.get_marker() == "^"]
        assert marks == [text.get_color() for text in whole.texts if "9 kN" in text.get_text()] == [colour]
        assert limits_hold(enlarged, 9.0)
        assert not any(line.get_marker() == "^" for line in enlarged.lines)
        assert not cut_texts(figure)


@pytest.mark.parametrize("later", [0.1, 1.0, 20.0])
def test_enlarged_impacts_have_a_force_axis_of_their_own(later):
    """Means of 11.5 and 15.9 kN in the first 50 ms, peaks twice as high, and a whirl with `later` times the second."""
    dataset = fall()
    t = dataset["time"].values
    first = np.searchsorted(t, LANDED) + 1
    for site, newtons in (("rb1", 11.5e3), ("rb2", 15.9e3)):
        mean = np.where(np.arange(len(t)) == first, newtons, 0.0) + np.where(t > LANDED + 0.1, later * 15.9e3, 0.0)
        dataset[f"rotor_contact.{site}.f_n_mean"] = ("time", mean)
        dataset[f"rotor_contact.{site}.f_n_peak"] = ("time", 2.0 * mean)
        dataset[f"rotor_contact.{site}.impulse"] = ("time", np.zeros(len(t)))
    alone, compared = plots.figure(dataset, "contact"), overlays({"a": dataset, "b": dataset})["contact"]
    for panels in (alone.axes[1:4:2], compared.axes[1:4:2]):
        for panel, kilonewtons in zip(panels, (11.5, 15.9), strict=True):
            assert np.ptp(panel.get_xlim()) == pytest.approx(0.05)
            assert 2.0 * kilonewtons < panel.get_ylim()[1] < 4.0 * kilonewtons
    for panel, largest in zip(alone.axes[:4:2], (max(11.5, later * 15.9), max(1.0, later) * 15.9), strict=True):
        assert panel.get_ylim()[1] > largest


def test_short_fall_is_enlarged_from_the_release_on():
    """A fall of 10 ms begins at 0.1 s, the release."""
    dataset = fall()
    shift = round((LANDED - 0.11) / 1e-3)
    for name in dataset.data_vars:
        if ".amplifier" not in name and name != "rotor_contact.speed":
            dataset[name] = ("time", np.roll(dataset[name].values, -shift))
    begin, end = plots.figure(dataset, "contact").axes[-1].get_xlim()
    assert (begin, end) == pytest.approx((0.1, 0.15), abs=2e-3)


def test_contact_without_a_fall_is_enlarged_from_before_its_first_touch():
    """A base shock takes no power away; the first force must not be at the edge."""
    dataset = fall()
    dataset["amb_actuator.mb1.amplifier_off_x"] = ("time", np.zeros(dataset.sizes["time"], bool))
    begin, _ = plots.figure(dataset, "contact").axes[-1].get_xlim()
    assert begin == pytest.approx(LANDED - 0.005, abs=2e-3)


def stands_on_a_face():
    """An upright rotor that falls along its shaft, and touches a face alone."""
    names = [f"{site}.{name}" for site in ("rb1", "rb2") for name in ("mode", "f_n", "impulse")]
    still = {name: np.zeros(3051) for name in (*names, "contact_state")}
    motion = {f"{bearing}.{axis}": np.full(3051, 1e-6) for bearing in ("mb1", "mb2") for axis in "xy"}
    dataset = fall(gravity=0.0, **still, **motion)
    t = dataset["time"].values
    gap = np.clip((LANDED - t) / (LANDED - RELEASE), 0.0, 1.0) * 0.25e-3
    for name, values in (("gap", gap), ("f_n", 100.0 * (t > LANDED)), ("mode", 1 * (t > LANDED))):
        dataset[f"rotor_contact.seat.{name}"] = ("time", values)
    sites = {"mb1": "rb1", "mb2": "rb2"}
    where = RotorPlaces(sites, ("rb1", "rb2"), magnetic=("mb1",), faces={"seat": "rb1"})
    return dataset.assign_attrs(places=where.to_json())


def test_fall_along_the_shaft_is_enlarged_as_the_gap_of_its_face():
    dataset = stands_on_a_face()
    panel = next(axes for axes in plots.figure(dataset, "touchdown").axes if axes.child_axes)
    assert panel.get_title("left") == "Gap along the shaft"
    drawn = plots.figure(dataset, "displacement").axes
    enlarged = drawn[[axes.get_title("left") for axes in drawn].index("Gap along the shaft") + 1]
    assert np.nanmax(enlarged.lines[0].get_ydata()) == pytest.approx(0.25, rel=0.01)
    assert [text.get_text() for text in enlarged.get_legend().texts] == ["seat"]
    assert enlarged.get_xlim()[1] - enlarged.get_xlim()[0] == pytest.approx(0.05)


@pytest.mark.parametrize(
    ("gravity", "label", "lowest"), [(9.81, "height (mm)", -1e3 * CLEARANCE), (0.0, "gap (mm)", 0.0)]
)
def test_compared_falls_are_heights_or_gaps_with_enlarged_impacts(gravity, label, lowest):
    panels = overlays({"a": fall(gravity), "b": fall(gravity)})["displacement"].axes
    assert {panel.get_ylabel() for panel in panels} == {label}
    assert np.nanmin(panels[0].lines[0].get_ydata()) == pytest.approx(lowest, abs=1e-6)
    assert np.ptp(panels[1].get_xlim()) == pytest.approx(0.05, abs=2e-3)


@pytest.mark.parametrize("width", [1.5, 2.4])
def test_position_in_a_title_is_one_line(width):
    title = site_title(placed(fall(), rb1=0.624), "rb1")
    assert any(line.startswith("at") and line.endswith("m") for line in fitted(title, width).split("\n"))


def test_touchdown_names_whirl_and_largest_force():
    dataset = fall()
    figure = plots.figure(dataset, "touchdown")
    title = figure.axes[0].get_title()
    assert_names(title, "backward whirl", f"{abs(WHIRL) * RPM:.3g} rpm")
    largest = largest_averaged_force(dataset, "rb1")
    assert force_unit(largest).text(largest, 3) in title
    still = fall(**{f"{site}.whirl_speed": np.zeros(3051) for site in ("rb1", "rb2")})
    assert "no whirl" in plots.figure(still, "touchdown").axes[0].get_title()
    for drawn in (figure, plots.figure(still, "touchdown")):
        assert not cut_texts(drawn)
        assert not overlapping_texts(drawn)
    (inset,) = [inset for axes in figure.axes for inset in axes.child_axes]
    panel = next(axes for axes in figure.axes if axes.child_axes)
    assert inset.get_tightbbox().y1 < panel.get_window_extent().y1  # below the names of events


def test_fall_is_drawn_as_height_or_gap_and_speed_not_from_zero():
    dataset = fall()
    dataset["rotor_contact.speed"] = ("time", np.linspace(OMEGA, 0.98 * OMEGA, dataset.sizes["time"]))
    height, *_, speed, _ = plots.figure(dataset, "displacement").axes
    assert height.get_ylabel() == "height (mm)"
    assert np.nanmin(height.lines[0].get_ydata()) == pytest.approx(-1e3 * CLEARANCE)
    assert speed.get_ylim()[0] > 0.9 * OMEGA * RPM
    gap = plots.figure(fall(gravity=0.0), "displacement").axes[0]
    assert gap.get_ylabel() == "gap (mm)"
    assert gap.lines[0].get_ydata()[-1] == pytest.approx(0.0, abs=1e-9)


def off_centre(gravity, offset, swing):
    """Return a fall onto retainers whose centres have an offset and swing on their mounts (m), the rotor with them."""
    still = fall(gravity)
    swung = swing * np.sin(40.0 * still["time"].values)
    motion = {f"{site}.housing_{axis}": swung for site in ("rb1", "rb2") for axis in "xy"}
    for name in (f"{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"):
        motion[name] = still[f"rotor_contact.{name}"].values + offset + swung
    moving = fall(gravity, **motion)
    parameters = json.loads(moving.attrs["parameters"])
    parameters["rotor_contact"] |= {f"{site}.offset_{axis}": offset for site in ("rb1", "rb2") for axis in "xy"}
    return moving.assign_attrs(parameters=json.dumps(parameters))


@pytest.mark.parametrize(("offset", "swing"), [(0.0, 0.5e-3), (0.2e-3, 0.0), (-0.2e-3, 0.5e-3)])
@pytest.mark.parametrize(("gravity", "lowest"), [(9.81, -1e3 * CLEARANCE), (0.0, 0.0)])
def test_orbits_and_heights_are_relative_to_a_retainer_that_moves(offset, swing, gravity, lowest):
    """The journal whirls around the ring and rests at its bottom, 0.75 mm from the centre of the ring."""
    dataset = off_centre(gravity, offset, swing)
    landed, displaced = (plots.figure(dataset, name) for name in ("touchdown", "displacement"))
    compared = overlays({"a": dataset, "b": fall(gravity)})["displacement"]
    orbit = landed.axes[0]
    (ring,) = orbit.patches
    assert tuple(ring.get_center()) == (0.0, 0.0)
    assert ring.get_radii()[0] - ring.get_width() == pytest.approx(1e3 * CLEARANCE)
    for line in orbit.lines[:2]:
        assert np.nanmax(np.hypot(*line.get_data())) == pytest.approx(1e3 * CLEARANCE)
    height = next(panel for panel in landed.axes if panel.get_ylabel() in ("height (mm)", "gap (mm)"))
    for panel in (height, displaced.axes[0], compared.axes[0]):
        line = panel.lines[0]
        assert np.nanmin(line.get_ydata()) == pytest.approx(lowest, abs=1e-9)
        assert line.get_ydata()[-1] == pytest.approx(lowest, abs=1e-9)
        limits = {float(y[0]) for y in (line.get_ydata() for line in panel.lines) if len(y) == 2 and y[0] == y[1]}
        assert sorted(limits) == pytest.approx([lowest])


def test_temperature_that_hardly_rises_has_no_offset():
    dataset = fall(**{"rb2.temperature": np.linspace(293.15, 293.150001, 3051)})
    figure = plots.figure(dataset, "touchdown")
    figure.canvas.draw()
    temperature = next(axes for axes in figure.axes if "temperature" in axes.get_ylabel())
    assert temperature.yaxis.get_offset_text().get_text() == ""
    assert np.ptp(temperature.get_ylim()) >= 1.0


def test_titles_state_positions_and_are_never_cut():
    words = " ".join(f"word{k}" for k in range(60))
    dataset = placed(fall().assign_attrs(description=words), rb1=0.06, rb2=0.5)
    for name in ("contact", "displacement", "touchdown", "orbits"):
        figure = plots.figure(dataset, name)
        assert "".join(figure._suptitle.get_text().split()).endswith("".join(words.split()))
        assert not cut_texts(figure)
        panel = next(axes for axes in figure.axes if axes.get_title() or axes.get_title("left"))
        title = " ".join((panel.get_title() or panel.get_title("left")).split())
        assert "0.06 m" in title
        assert "MB1" not in title


@pytest.mark.parametrize(("second", "position"), [(0.06, True), (0.07, False)])
def test_compared_figures_state_positions_in_which_runs_agree(second, position):
    runs = {"a": placed(fall(), rb1=0.06, rb2=0.5), "b": placed(fall(), rb1=second, rb2=0.5)}
    drawn = overlays(runs)
    assert set(drawn) == {"orbits", "displacement", "contact"}
    for figure in drawn.values():
        first = next(axes for axes in figure.axes if axes.get_title() or axes.get_title("left"))
        title = " ".join((first.get_title() or first.get_title("left")).split())
        assert ("0.06 m" in title) is position
        assert not cut_texts(figure)


@pytest.mark.parametrize("later", slow_but_first([0.002, 0.0, 0.1, 1.0]))
def test_names_of_events_do_not_overlap(synthetic, later):
    """A shock of 0.1 cycles has no room for two names; both are in one label."""
    dataset = synthetic(
        disturbance_cycle=5.0, relief_cycle=5.0 + later, disturbance_label="shock", relief_label="end_of_shock"
    )
    for name in ("contact", "displacement", "magnets", "energy", "whirl"):
        if not plots._lacks(dataset, name):
            figure = plots.figure(dataset, name)
            assert not overlapping_texts(figure), name
            written = " ".join(text.get_text() for text in visible_texts(figure))
            assert "shock" in written
            assert "end of shock" in written


def test_upright_rotor_has_no_up():
    """The scenario states a gravity of 0 across the shaft; a rotor whose gravity is left out is seen from its stand."""
    left_out = fall(gravity=0.0)
    upright = left_out.assign_attrs(scenario_data=json.dumps({"gravity": 0}))
    for dataset, labels in ((left_out, {"to the right (mm)", "up (mm)"}), (upright, {"$x$ (mm)", "$y$ (mm)"})):
        panel = plots.figure(dataset, "orbits").axes[0]
        assert {panel.get_xlabel(), panel.get_ylabel()} == labels
    assert not plots.figure(upright, "orbits").axes[0].texts


def test_whirl_of_rolling_follows_a_race_that_turns():
    """(Omega - omega_r) R_s = omega_r c - omega c: a race at which a journal rolls with the whirl of the run."""
    radius = 30e-3
    race = (OMEGA * radius + WHIRL * CLEARANCE) / (radius + CLEARANCE)
    dataset = fall(**{"rb1.race_speed": np.full(3051, race), "speed": np.full(3051, OMEGA)})
    parameters = json.loads(dataset.attrs["parameters"])
    parameters["rotor_contact"] |= {
        "rb1.journal_radius": radius,
        "rb2.journal_radius": radius,
        "rb1.race_inertia": 1e-4,
    }
    panels = plots.figure(dataset.assign_attrs(parameters=json.dumps(parameters)), "whirl").axes
    for panel, whirl, is_written in ((panels[0], WHIRL, False), (panels[2], -OMEGA * radius / CLEARANCE, True)):
        assert panel.lines[1].get_ydata() == pytest.approx(np.full(3051, whirl * RPM))
        assert any("rolling" in text.get_text() for text in panel.texts) is is_written


@pytest.mark.parametrize(("times", "scale"), [(5.0, "linear"), (30.0, "symlog")])
def test_whirl_much_faster_than_the_spin_has_a_logarithmic_axis(times, scale):
    """The journal rolls with a whirl of 5 or 30 times the spin speed, as the text beside the line states."""
    dataset = fall(speed=np.full(3051, OMEGA), **{"rb1.whirl_speed": np.full(3051, -times * OMEGA)})
    parameters = json.loads(dataset.attrs["parameters"])
    parameters["rotor_contact"] |= {f"{site}.journal_radius": times * CLEARANCE for site in ("rb1", "rb2")}
    figure = plots.figure(dataset.assign_attrs(parameters=json.dumps(parameters)), "whirl")
    panel, rolling = figure.axes[0], -times * OMEGA * RPM
    assert panel.get_yscale() == scale
    assert limits_hold(panel, rolling)
    (text,) = [text for text in panel.texts if "rolling" in text.get_text()]
    assert f"{-rolling:,.0f} rpm" in text.get_text()
    assert text.get_position()[1] == pytest.approx(rolling)
    assert not cut_texts(figure)


@pytest.mark.parametrize("speeds", [(1.0, 0.1), (0.1, 1.0), (1.0, 1.0), (1.0, 0.999), (1.0, 0.0)])
def test_whirl_of_rolling_is_written_as_a_range_if_the_spin_changes(speeds):
    """-Omega R/c with R = 30 c, from the lowest to the highest; a change of 0.1 % is one speed."""
    sweep = OMEGA * np.linspace(*speeds, 3051)
    dataset = fall(speed=sweep, **{"rb1.whirl_speed": -30.0 * sweep})
    parameters = json.loads(dataset.attrs["parameters"])
    parameters["rotor_contact"] |= {f"{site}.journal_radius": 30.0 * CLEARANCE for site in ("rb1", "rb2")}
    figure = plots.figure(dataset.assign_attrs(parameters=json.dumps(parameters)), "whirl")
    (text,) = [text for text in figure.axes[0].texts if "rolling" in text.get_text()]
    numbers = re.findall(r"[\d,]+", text.get_text().replace("\N{MINUS SIGN}", ""))
    expected = [30.0 * RPM * OMEGA * share for share in sorted(speeds, reverse=True)]
    if np.ptp(speeds) < 0.01:
        expected = [np.mean(expected)]
    assert [float(number.replace(",", "")) for number in numbers] == pytest.approx(expected, abs=1.0)
    on_the_slow_side = text.get_ha() == ("right" if speeds[1] < speeds[0] else "left")
    assert on_the_slow_side or len(expected) == 1
    assert not cut_texts(figure)


def test_figures_of_heights_state_the_dashed_line_and_units_of_the_inset():
    displaced, landed = (plots.figure(fall(), name) for name in ("displacement", "touchdown"))
    for figure in (displaced, landed):
        entries = [text.get_text() for text in figure.legends[0].texts]
        assert sum("at rest" in entry and "rigid" in entry for entry in entries) == 1
        assert not cut_texts(figure)
    (inset,) = [inset for axes in landed.axes for inset in axes.child_axes]
    assert_names(inset.get_title("left"), "height (mm)", "time (s)")
