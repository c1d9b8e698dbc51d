"""Campbell diagrams: labels do not overlap, and damping lies in its zones."""

import math
import warnings
from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from drawn import cut_texts, overlapping_texts, titles
from matplotlib.collections import LineCollection

from amb_analysis.studies.campbell_diagram import CampbellDiagram, CriticalSpeedRow, ModeOverSpeed
from amb_analysis.studies.closed_loop_poles import ClosedLoopPoles, LeastDamped, PoleOverSpeed
from amb_analysis.studies.coefficient_limits import limits_of
from amb_analysis.studies.figures import figure, over_speed
from amb_analysis.studies.figures.over_speed import damping_ratio
from amb_analysis.studies.unbalance_records import CriticalResponse, PlaceResponse, UnbalanceResponse
from amb_cosim import studies
from amb_cosim.presentation.style import StyledFigure
from amb_cosim.presentation.units import units
from amb_cosim.results.loop_stability import LoopStability
from rotor_analysis.parts import AtSpeed, Bearing
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names


def test_100_modes_with_critical_speeds_have_labels_that_do_not_overlap():
    """Mode n has n rad/s, so that all 100 are critical, and all have the same damping ratio."""
    speeds = np.linspace(0.0, 400.0, 5)
    modes = tuple(ModeOverSpeed(np.full(5, float(n)), np.full(5, 0.01), ("forward",) * 5) for n in range(1, 101))
    critical = tuple(CriticalSpeedRow(float(n), n, 0.01, "forward") for n in range(1, 101))
    picture = figure(CampbellDiagram("any", "consistent", speeds, modes, critical, 1200, 1200, 0.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        picture.savefig(BytesIO())
    assert [axes.get_position().height > 0.2 for axes in picture.axes[:2]] == [True, True]
    for axes in picture.axes[:2]:
        numbers = [text for text in axes.texts if text.get_text().isdigit()]
        boxes = sorted(text.get_window_extent().bounds for text in numbers)
        heights = sorted(y for _, y, _, _ in boxes)
        assert 10 <= len(numbers) <= 24
        assert min(np.diff(heights)) >= 0.9 * boxes[0][3]  # digits do not fill their boxes
        inside = axes.get_window_extent()
        assert heights[0] > inside.y0 - boxes[0][3]
        assert heights[-1] < inside.y1
    labels = [text.get_text() for text in picture.axes[0].texts if ": " in text.get_text()]
    assert 10 <= len(labels) <= 24


def test_decrement_and_damping_ratio_describe_the_same_decay():
    """exp(-delta) is the next amplitude over this one: exp(-zeta omega_0 T) with T = 2 pi/(omega_0 sqrt(1-zeta^2))."""
    zeta = 0.2
    delta = zeta * 2.0 * math.pi / math.sqrt(1.0 - zeta**2)
    assert damping_ratio(delta) == pytest.approx(zeta)


def crossing_poles() -> ClosedLoopPoles:
    """One vibration of 100 rad/s, whose decrement falls from 0.2 to 0.1, and one far above."""
    speeds = np.linspace(0.0, 200.0, 21)
    decrements = np.linspace(0.2, 0.1, 21)
    poles = tuple(
        PoleOverSpeed(np.full(21, f), decrements / (2.0 * math.pi), decrements, ("forward",) * 21)
        for f in (100.5, 900.0)
    )
    sample_time, growth = 1e-4, -decrements * 100.5 / (2.0 * math.pi)
    radii = np.exp(growth * sample_time)
    return ClosedLoopPoles(
        scenario="any",
        rotor="any",
        sample_time=sample_time,
        speeds=speeds,
        poles=poles,
        least_damped=LeastDamped(decrements[-1] / (2.0 * math.pi), speeds[-1], 100.5, "forward"),
        spectral_radii=radii,
        growth_rates=growth,
        least_stable=LoopStability(radii[-1], growth[-1], 100.5, speeds[-1]),
        unstable=(),
        operating_speed=150.0,
    )


def entries_of(picture):
    """Texts of all legends of the parts of a figure."""
    return [text.get_text() for part in picture.subfigs for legend in part.legends for text in legend.texts]


def test_vibration_frequency_at_a_critical_speed_is_that_of_rotation():
    (critical,) = crossing_poles().critical_speeds
    assert (critical.mode, critical.speed) == (1, pytest.approx(100.5))
    assert critical.decrement == pytest.approx(0.14975)


@pytest.mark.parametrize("whirl", ["forward", "backward", "mixed"])
def test_critical_speeds_and_the_least_damped_vibration_of_a_loop_have_their_whirl(whirl):
    """Only a forward whirl follows the unbalance at a critical speed."""
    made = crossing_poles()
    first, second = made.poles
    poles = replace(
        made,
        poles=(replace(first, whirl=(whirl,) * 21), second),
        least_damped=replace(made.least_damped, whirl=whirl),
    )
    (critical,) = poles.critical_speeds
    assert critical.whirl == whirl
    answer, *_ = poles.text()
    (line,) = [part for part in poles.text() if isinstance(part, str) and part.startswith("critical speeds")]
    assert_names(answer, whirl)
    assert_names(line, "959.7 rpm", whirl)


def test_whirl_of_a_critical_speed_is_that_of_the_sample_beside_it():
    """The vibration of 100.5 rad/s changes its sense between 100 and 110 rad/s; 100 is nearer."""
    made = crossing_poles()
    turned = replace(made.poles[0], whirl=("backward",) * 11 + ("forward",) * 10)
    assert [critical.whirl for critical in replace(made, poles=(turned,)).critical_speeds] == ["backward"]


def test_critical_speeds_beyond_the_table_of_a_seal_are_marked():
    rows = tuple(AtSpeed(speed, ((1e5, 0.0), (0.0, 1e5))) for speed in (0.0, 50.0))
    result = replace(crossing_poles(), limits=limits_of((Bearing("labyrinth", 1, at_speed=rows),)))
    assert_names(
        str(result), "labyrinth", "0 to 477.5 rpm", "959.7 rpm (mode 1, forward, decrement 0.15, extrapolated)"
    )
    assert [any(patch.get_hatch() for patch in axes.patches) for axes in figure(result).axes] == [True, True, False]
    assert "extrapolated" not in str(crossing_poles())


def test_legend_of_poles_is_not_cut():
    """A vibration far above the axes has the longest entry."""
    fast = replace(crossing_poles(), least_damped=LeastDamped(0.0001234, 200.0, 14857.0, "forward"))
    picture = figure(fast)
    assert any("triangle" in text.get_text() for text in titles(picture))
    assert not cut_texts(picture)


def test_poles_begin_with_the_stability_and_the_least_damped_vibration():
    stable = crossing_poles()
    assert_names(stable.text()[0], "stable up to")
    assert "not stable" not in stable.text()[0]
    unstable = replace(stable, unstable=(float(stable.speeds[1]),))
    assert_names(unstable.text()[0], "not stable", "95.49 rpm")
    with units("rpm"):
        assert all("Hz" not in result.text()[0] for result in (stable, unstable))


def heads_of(result):
    """Heads of the first table of a result, and the first cell of each column."""
    table = next(part for part in result.text() if not isinstance(part, str))
    return {str(column.header): next(iter(column.cells)) for column in table.columns}


@pytest.mark.usefixtures("few_speeds")
def test_tables_of_studies_are_in_rpm_and_hz_or_in_chosen_units():
    """900 rad/s are 8594 rpm and 143.2 Hz."""
    modes = studies.modes("compressor", speeds="900 rad/s", count=2)
    assert heads_of(modes)["speed (rpm)"] == "8594.37"
    omega = modes.frequencies.speeds[900.0].frequencies[0]
    assert float(heads_of(modes)["frequency (Hz)"]) == pytest.approx(omega / (2.0 * np.pi), rel=1e-5)
    critical = studies.campbell("compressor", up_to="900 rad/s")
    response = studies.unbalance_response(scenario="compressor_levitated", up_to="9000 rpm")
    unit_of = {"rpm": 30.0 / np.pi, "rad/s": 1.0}
    for name, factor in unit_of.items():
        with units(name, "um"):
            shown = heads_of(critical)[f"speed ({name})"]
            assert float(shown) == pytest.approx(factor * critical.critical_speeds[0].speed, rel=1e-5)
            at_peak, place = heads_of(response), next(iter(response.places.values()))
            assert float(at_peak["amplitude (\N{MICRO SIGN}m)"]) == pytest.approx(1e6 * place.amplitude.max(), rel=1e-3)
            peak = response.speeds[place.amplitude.argmax()]
            assert float(at_peak[f"speed ({name})"]) == pytest.approx(factor * peak, rel=1e-3)


def test_least_damped_vibration_is_marked_even_beyond_the_axes():
    """2276 Hz with a decrement of 0.0026 at 150 rad/s, where the figure follows vibrations up to 143 Hz."""
    decrement = 0.0026
    ratio = decrement / np.hypot(2.0 * np.pi, decrement)
    least = LeastDamped(ratio, 150.0, 2.0 * np.pi * 2276.0, "backward")
    picture = figure(replace(crossing_poles(), least_damped=least))
    frequency, damping, plane = picture.axes
    marks = [[line for line in axes.lines if line.get_marker() in "^vD"] for axes in picture.axes]
    assert [[mark.get_marker() for mark in of_axes] for of_axes in marks] == [["^"], ["D"], ["^"]]
    assert [of_axes[0].get_ydata()[0] for of_axes in marks[::2]] == [frequency.get_ylim()[1], plane.get_ylim()[1]]
    assert marks[1][0].get_ydata()[0] == pytest.approx(decrement, rel=1e-6)
    assert damping.get_ylim()[0] < decrement
    with units("rad/s"):
        entries = entries_of(figure(replace(crossing_poles(), least_damped=least)))
    assert any("at 150 rad/s" in entry for entry in entries if "least" in entry)
    assert_names(" ".join(entries_of(picture)), "2276 Hz", "0.0026")
    seen = figure(crossing_poles()).axes
    assert [[line.get_marker() for line in axes.lines if line.get_marker() in "^vD"] for axes in seen] == [["D"]] * 3


def test_mark_at_the_end_of_a_curve_leaves_its_number_free():
    picture = figure(crossing_poles())
    picture.canvas.draw()
    for axes in picture.axes[:2]:
        (mark,) = [line for line in axes.lines if line.get_marker() in "^vD"]
        half = 0.72 * mark.get_markersize() / 72.0 * picture.dpi  # of the diagonal of a diamond, with its edge
        right = axes.transData.transform(mark.get_xydata()[0])[0] + half
        numbers = [text for text in axes.texts if text.get_text().isdigit()]
        assert numbers
        assert all(text.get_window_extent().x0 > right for text in numbers)


def test_hollow_marks_of_critical_speeds_are_in_the_legend():
    """A critical speed at the decrement 0.15 amplifies more than 2.5 times, one at 1.5 less."""

    def entries(factor):
        poles = tuple(replace(pole, decrements=factor * pole.decrements) for pole in crossing_poles().poles)
        return entries_of(figure(replace(crossing_poles(), poles=poles)))

    assert not any("2.5" in text for text in entries(1.0))
    assert any("below 2.5" in text for text in entries(10.0))


def test_axis_of_damping_ends_near_its_curves_and_numbers_are_joined_to_them():
    """Damping ratios of 0.13 to 0.28, of which three are alike."""
    speeds = np.linspace(0.0, 400.0, 5)
    modes = tuple(ModeOverSpeed(np.full(5, 300.0), np.full(5, z), ("forward",) * 5) for z in (0.13, 0.28, 0.28, 0.28))
    diagram = CampbellDiagram("any", "consistent", speeds, modes, (), 8, 8, 0.0)
    picture = figure(diagram)
    low, high = picture.axes[1].get_ylim()
    assert 0.05 < low < 0.13 < 0.28 < high < 0.6
    joined = [line.get_segments()[0][0][1] for line in picture.axes[1].findobj(LineCollection)]
    assert len(joined) == 2
    assert np.ptp(joined) == pytest.approx(0.0)
    assert_names(picture.get_suptitle(), "bearings")
    assert_names(figure(replace(diagram, is_free=True)).get_suptitle(), "free")


def test_small_amplitudes_of_a_levitated_machine_are_away_from_the_polar_origin():
    """At the operating speed the amplitude is a hundredth of the peak's; the legend states it."""
    speeds = np.linspace(1.0, 200.0, 200)
    amplitude = np.where(speeds < 150.0, 1e-6, 1e-4)
    place = PlaceResponse(1, 0.0, None, amplitude, np.zeros(200), amplitude)
    response = UnbalanceResponse(*("any", np.eye(2), "any", 100.0, 1e-4, 0.0, {}, speeds, {"end": place}, ()))
    with units("rad/s", "um"):
        polar = figure(response)
        alone = figure(replace(response, scenario=""))
    axes = polar.axes[-1]
    origin, low, high = (axes.transData.transform((0.0, r))[0] for r in (axes.get_rmin(), 1.0, 100.0))
    assert low - origin > 0.3 * (high - origin)
    assert alone.axes[-1].get_rmin() == 0.0
    assert_names(" ".join(entries_of(polar)), "operating speed, 100 rad/s: 1 \N{MICRO SIGN}m")


def test_response_ends_where_the_loop_is_not_stable_and_says_so():
    """An operating speed of 100, a loop that is stable up to 200 and a peak at 199 rad/s, whole within the axis."""
    speeds = np.linspace(1.0, 200.0, 200)
    amplitude = 1e-5 / np.hypot(1.0, 199.0 - speeds)
    place = PlaceResponse(1, 0.0, None, amplitude, np.zeros(200), amplitude)
    response = UnbalanceResponse(
        *("any", np.eye(2), "any", 100.0, 1e-4, 0.0, {}, speeds, {"end": place}, ()), stable_up_to=200.0
    )
    with units("rad/s"):
        top = figure(response).axes[0]
    assert top.get_xlim()[1] > 200.0
    (shade,) = [patch for patch in top.patches if patch.get_hatch()]
    assert shade.get_x() == pytest.approx(200.0)


def test_names_of_clearances_are_on_no_line_and_under_no_other_text():
    """Two clearances that are close, and two critical speeds."""
    speeds = np.linspace(1.0, 200.0, 200)
    amplitude = 1e-5 / np.hypot(1.0, 150.0 - speeds)
    places = {
        name: PlaceResponse(1, 0.0, clearance, amplitude, np.zeros(200), amplitude)
        for name, clearance in (("a", 250e-6), ("b", 300e-6))
    }
    peaks = tuple(CriticalResponse("a", speed, 1e-5, 5.0, 50.0) for speed in (20.0, 150.0))
    picture = figure(UnbalanceResponse(*("any", np.eye(2), "any", 100.0, 1e-4, 0.0, {}, speeds, places, peaks)))
    assert not overlapping_texts(picture)
    top = picture.axes[0]
    (box,) = [text.get_window_extent() for text in top.texts if "clearance" in text.get_text()]
    for clearance in (250.0, 300.0):
        height = top.transData.transform((100.0, clearance))[1]
        assert not box.y0 < height < box.y1


@pytest.mark.parametrize("end", [0.9, 0.95, 1.0])
def test_label_of_rotation_covers_no_curve_and_no_critical_speed(end):
    """A frequency that ends where the label of 1x usually is, with a critical speed there."""
    axes = StyledFigure(figsize=(7.0, 5.0)).subplots()
    axes.plot(np.linspace(0.0, 100.0, 9), np.full(9, 100.0 * end))
    axes.set(xlim=(0.0, 100.0), ylim=(0.0, 300.0))
    over_speed._draw_multiples(axes)
    over_speed.label_points(axes, [(100.0 * end, 100.0 * end, f"1: {100.0 * end:.0f}", "C0")])
    axes.figure.canvas.draw()
    assert not overlapping_texts(axes.figure)
    (box,) = [text.get_window_extent() for text in axes.texts if text.get_text() == "1x"]
    height = axes.transData.transform((50.0, 100.0 * end))[1]
    assert not box.y0 < height < box.y1


def test_diagrams_of_a_rotor_reach_beyond_the_speed_at_which_it_runs():
    """The compressor runs at 9000 rpm and trips at 9900 rpm, as its rotor file says; the rig's file says nothing."""
    rpm = np.pi / 30.0
    trips = studies.campbell("compressor", count=2)
    assert trips.speeds[-1] == load_rotor("compressor").reduction.speed == pytest.approx(9900.0 * rpm, rel=1e-3)
    assert studies.campbell("compressor", speed="9000 rpm", count=2).speeds[-1] == pytest.approx(11250.0 * rpm)
    assert studies.campbell("bath_rig_thesis", count=2).speeds[-1] == pytest.approx(6000.0 * rpm)
    response = studies.unbalance_response("compressor", unbalance="1 g.m", place="impeller1")
    assert response.speeds[-1] == trips.speeds[-1]
    assert_names(str(trips), "up to 9903 rpm")


@pytest.mark.usefixtures("few_speeds")
def test_critical_speeds_name_their_unbalance():
    response = studies.unbalance_response(scenario="compressor_levitated", up_to="12000 rpm")
    titles = [str(block.title) for block in response.text() if not isinstance(block, str) and block.title]
    for title in titles:
        assert_names(title, "650 g mm", "impeller3")
    assert any("ritical" in title for title in titles)
