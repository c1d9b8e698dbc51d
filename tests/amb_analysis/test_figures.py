"""Figures of studies: labels beside curves, words in areas, marks beside ridges, limits of axes."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from drawn import cut_texts, overlapping_texts
from matplotlib.axes import Axes
from matplotlib.text import Text
from mpl_toolkits.mplot3d import proj3d

from amb_analysis import studies
from amb_analysis.studies.contact_convergence import ContactConvergence, ConvergenceRow
from amb_analysis.studies.convergence_runs import Contact
from amb_analysis.studies.figures import convergence, layout, modes, over_speed, response, sensitivity, traps, waterfall
from amb_analysis.studies.frequency_responses import ComputedResponse, FrequencyResponses
from amb_analysis.studies.rotor_layout import layout as layout_of
from amb_analysis.studies.stability_margin import AxisSensitivity, DiskMargin, GangOfFour, StabilityMargin
from amb_analysis.studies.unbalance_records import CriticalResponse
from amb_cosim.presentation.style import StyledFigure, write_title
from tests.support.messages import assert_names


def panel_with_curves(*heights):
    """Axes from 0 to 10 with level curves and the line y = x."""
    figure = StyledFigure(figsize=(7.0, 6.0))
    axes = figure.subplots()
    x = np.linspace(0.0, 10.0, 50)
    for height in (*(np.full(50, h) for h in heights), x):
        axes.plot(x, height)
    axes.set(xlim=(0.0, 10.0), ylim=(0.0, 10.0))
    return figure, axes


@pytest.mark.parametrize("heights", [(5.0,), (1.0, 1.05), (0.3, 0.32, 0.6, 9.8), (4.0, 4.2, 4.4, 4.6)])
def test_labels_of_critical_speeds_are_beside_their_curves(heights):
    """Where curve and speed are equal, a label covers no curve, no point and no other label."""
    figure, axes = panel_with_curves(*heights)
    over_speed.label_points(axes, [(h, h, f"{k}: {100.0 * h:.0f}", "C0") for k, h in enumerate(heights, 1)])
    figure.canvas.draw()
    assert len(axes.texts) == len(heights)
    assert not overlapping_texts(figure)
    to_axes = axes.transData.inverted()
    for text in axes.texts:
        assert text.get_bbox_patch().get_facecolor() == (1.0, 1.0, 1.0, 1.0)
        box = Text.get_window_extent(text)
        points = axes.transData.transform([(h, h) for h in heights])
        assert not any(box.contains(*point) for point in points)
        low, high = to_axes.transform(box.get_points())[:, 1]
        left, right = to_axes.transform(box.get_points())[:, 0]
        assert not any(low < h < high for h in heights), text.get_text()
        assert not any(low < x < high for x in np.linspace(left, right, 20)), "on the line 1x"


@pytest.mark.parametrize(
    ("amplification", "speed", "required"),
    [(2.4, 1.0, None), (3.5, 1.0, 8.5), (40.0, 1.0, 16.0), (3.5, 3.0, 18.5), (40.0, 3.0, 26.0)],
)
def test_required_margin_is_that_of_api_617(amplification, speed, required):
    """At AF = 3.5 the share is 17/2; a peak above the speed requires 10 % more, and none more than 16 or 26 %."""
    peak = CriticalResponse("end", speed, 1e-5, amplification, 50.0)
    assert peak.required_margin(2.0) == (None if required is None else pytest.approx(required))


def margin(peak):
    f = np.geomspace(1.0, 1000.0, 400)
    S = 1.0 + (peak - 1.0) / (1.0 + 1j * 20.0 * np.log(f / 100.0))
    axis = AxisSensitivity(peak, 100.0, "A", S, f[::8], np.abs(S[::8]), peak, 0.0, 0.0)
    disk = DiskMargin(np.ones(400), 0.5, 100.0, 1.5, 20.0)
    gang = GangOfFour(*[np.abs(S)] * 4)
    fields = dict(scenario="made up", rotor="made up", warnings=[], speed=100.0, sample_time=1e-4, delay=1.0)
    shown = dict(amplifier="ideal", settings=(), zone_limits={"A": 3.0, "B": 4.0, "C": 5.0}, frequencies=f)
    axes = {"left.x": axis, "left.y": axis}
    return StabilityMargin(
        **fields, **shown, axes=axes, gang_of_four=gang, disk_margins={"currents": disk, "sensors": disk}
    )


def test_equal_disk_margins_are_both_visible():
    panel = next(a for a in sensitivity.draw(margin(1.4)).findobj(Axes) if a.get_ylabel() == "disk margin")
    currents, sensors = panel.lines
    assert currents.get_linewidth() > 2.0 * sensors.get_linewidth()


@pytest.mark.parametrize("peak", [1.4, 2.6, 12.0])
def test_axis_of_sensitivity_ends_at_1_3_times_the_largest_peak(peak):
    figure = sensitivity.draw(margin(peak))
    panel = next(axes for axes in figure.findobj() if getattr(axes, "get_title", lambda: "")().startswith("left"))
    assert panel.get_ylim() == pytest.approx((0.0, 1.3 * peak), rel=0.01)
    assert all(text.get_position()[1] <= panel.get_ylim()[1] for text in panel.texts)


def test_an_odd_number_of_axes_leaves_no_empty_panel():
    five = margin(1.4)
    axes = {name: five.axes["left.x"] for name in ("left.x", "left.y", "right.x", "right.y", "thrust.z")}
    panels = [panel for panel in sensitivity.draw(replace(five, axes=axes)).findobj(Axes) if panel.axison]
    assert len(panels) == 5 + 2 + 1  # of the axes, of all loops, and the Nyquist plot


def test_a_response_that_is_zero_has_no_phase():
    f = np.geomspace(1.0, 100.0, 50)
    curves = {"thrust.z/bell.f_x": ComputedResponse("m/N", f, np.zeros(50, complex))}
    amplitude, phase = response.draw(FrequencyResponses("made up", "closed", 0.0, curves, ())).findobj(Axes)
    assert not amplitude.lines[0].get_ydata().any()
    assert np.isnan(phase.lines[0].get_ydata()).all()


def test_words_are_in_their_areas():
    """Free on the left, in contact on the right; a strip that is too narrow keeps its entry of the legend."""
    kinds = np.zeros((100, 40), int)
    kinds[60:, :], kinds[58:60, :] = 2, 1
    speeds, amounts = np.linspace(0.0, 100.0, 100), np.linspace(1.0, 40.0, 40)
    result = SimpleNamespace(kinds=kinds, speeds=speeds, speed=30.0, unbalance=0.02)
    panel = StyledFigure().subplots()
    assert traps._name_areas(panel, result, speeds, amounts) == {0, 2}
    for text in panel.texts:
        x, y = text.get_position()
        kind = kinds[int(np.argmin(np.abs(speeds - x))), int(np.argmin(np.abs(amounts - y)))]
        assert text.get_text().replace("\n", " ") == traps.LABELS[kind]


def test_states_of_contact_at_a_single_speed_are_visible_points():
    states = SimpleNamespace(
        contact=(0,),
        speed=np.array([4, 4]),
        N=np.array([[1.90e5], [1.95e5]]),
        psi=np.zeros((2, 1)),
        stable=np.array([False, False]),
    )
    result = SimpleNamespace(
        curves=SimpleNamespace(speeds=np.linspace(0.0, 100.0, 11), states=[None, states]),
        speed=30.0,
        sites=("rb1",),
        states=(),
    )
    panel = StyledFigure().subplots()
    traps._draw_forces(panel, result)
    assert any(line.get_marker() == "." and len(line.get_xdata()) for line in panel.lines)
    low, high = panel.get_ylim()
    assert high / low == pytest.approx(10.0)
    assert panel.get_legend().texts[0].get_text() == "RB1"


@pytest.mark.parametrize(("largest", "end"), [(0.25, 1.2), (1.5, 1.8), (9.0, 2.0)])
def test_axis_of_orbits_suits_them_and_its_legend_names_each_line(largest, end):
    result = SimpleNamespace(
        curves=SimpleNamespace(
            speeds=np.linspace(0.0, 100.0, 11), states=[SimpleNamespace(speed=np.arange(11), dynamics=[])]
        ),
        orbits=np.linspace(0.0, largest, 11)[:, None],
        clearances=np.array([1.0]),
        speed=10.0 * np.pi,
        sites=("rb1",),
    )
    panel = StyledFigure().subplots()
    traps._draw_orbits(panel, result)
    assert panel.get_ylim() == pytest.approx((0.0, end))
    legend = panel.get_legend()
    assert [text.get_text() for text in legend.texts] == ["RB1", "would touch", "at 300 rpm"]
    assert legend.get_frame_on()


def test_sites_of_a_convergence_run_are_beside_each_other():
    sites = {name: Contact(1e3, 1e3, 1.0, 1.0) for name in ("left", "right")}
    row = ConvergenceRow("scenario", "scenario", 1.0, 0, sites, None, None, "", None)
    fields = dict(scenario="made up", rotor="made up", warnings=[], rows=(row, replace(row, start=1)))
    unknown = dict.fromkeys(("scatter", "change", "step_change", "averaged_change", "averaged_step_change", "chaotic"))
    picture = convergence.draw(ContactConvergence(**fields, **unknown))
    places = [line.get_xdata()[0] for line in picture.axes[0].lines]
    assert len({*places}) == 4
    assert_names(picture.get_suptitle(), "start k", "1e-06")


def test_marks_of_rotation_leave_the_ridge_free():
    speeds, frequencies = np.linspace(5.0, 30.0, 40), np.linspace(-60.0, 60.0, 241)
    panel = StyledFigure().subplots()
    panel.set_xlim(frequencies[0], frequencies[-1])
    waterfall._point_at_rotation(panel, speeds, speeds, "white")
    for line in panel.lines:
        assert line.get_linestyle() == "None"
        beside = np.abs(line.get_xdata()) - line.get_ydata()
        assert beside.min() > 3.0 * 0.5  # of the distance of the frequencies
        assert beside.max() < 0.035 * 120.0


def test_parts_are_marked_on_the_drawing_of_a_rotor():
    result = layout_of("compressor")
    above = layout.draw(result).axes[0]
    marked = {round(float(line.get_xdata()[0]), 6) for line in above.lines if line.get_marker() not in ("", "None")}
    assert {round(part.z, 6) for part in result.parts if part.kind != "disc"} <= marked
    places = [
        (line.get_xdata()[0], line.get_ydata()[0]) for line in above.lines if line.get_marker() not in ("", "None")
    ]
    assert len(places) == len({*places}) == 3 * 1 + 2 * (2 + 3)  # sensors above; bearings and sites on both sides
    assert_names(layout.draw(result).get_suptitle(), "Hz at rest", "bearings of its file")


@pytest.mark.parametrize("width", [4.0, 10.0])
def test_long_titles_are_wrapped(width):
    figure = StyledFigure(figsize=(width, 3.0), layout="constrained")
    figure.subplots()
    words = "a title with $\\Omega$ = 3 and many words " * 6
    write_title(figure, words)
    assert figure.get_suptitle().split() == words.split()
    assert not cut_texts(figure)


def test_a_resonance_without_damping_does_not_set_the_scale():
    """A free mass falls by a factor of 1e6, with a pole of 1e12; a damped one of 500 is drawn whole."""
    f = np.geomspace(1.0, 1e3, 601)
    low, high = response._limits(np.where(f == f[300], 1e12, 1e-4 / f**2))
    assert low is None
    assert 1e-4 <= high < 1e-2
    assert response._limits(np.where(f == f[300], 500.0, 1.0)) == (None, None)
    assert response._limits(np.zeros(601)) == (None, None)


def test_titles_of_mode_shapes_are_above_their_boxes_and_labels_in_their_panels():
    figure = modes.draw(studies.modes("bath_rig_thesis"))
    figure.canvas.draw()
    for axes in figure.axes:
        corners = itertools.product(axes.get_xlim(), axes.get_ylim(), axes.get_zlim())
        [label] = axes.texts
        points = np.array([*corners, label.get_position_3d()]).T
        x, y, _ = proj3d.proj_transform(*points, axes.get_proj())
        at = axes.transData.transform(np.column_stack([x, y]))
        assert axes.title.get_window_extent().y0 > at[:-1, 1].max()
        panel = axes.get_subplotspec().get_position(figure)
        assert panel.contains(*figure.transFigure.inverted().transform(at[-1]))
