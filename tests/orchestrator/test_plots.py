"""Figures of a synthetic run: which are drawn, and their content."""

import json
from dataclasses import replace

import numpy as np
import pytest
from falls import CLEARANCE, LANDED, OMEGA, fall
from matplotlib.text import Text
from slow import slow_but_first

import amb_cosim
from amb_assessment.reporting.panels import run_panels
from amb_cosim.comparison.plots import overlays
from amb_cosim.presentation.style import StyledFigure
from amb_cosim.results import plots
from amb_cosim.results.plots import motion
from amb_cosim.results.plots.fall import touchdown
from amb_cosim.results.plots.joined import draw_joined, joined
from amb_cosim.results.plots.magnets import _draw_limits
from tests.orchestrator.conftest import PLACES
from tests.support.messages import assert_names, raises_naming

RPM = 30.0 / np.pi  # 1/min per rad/s
USUAL = ["orbits", "displacement", "contact"]


def profile(*points):
    return {"speed_profile": json.dumps(points)}


def drawn(dataset, folder):
    paths = plots.draw_all(dataset, folder)
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in paths)
    return [p.stem for p in paths]


def test_a_flight_that_vibrates_faster_than_its_samples_is_dots():
    """Turns of 100 degrees in the middle look like bounces. 30 degrees are an orbit; near the retainer it bounces."""
    figure = StyledFigure()

    def drawn(degrees, centre):
        turns = np.radians(degrees) * np.arange(6)
        path = np.array([centre + 0.1 * np.cos(turns), 0.1 * np.sin(turns)])
        panel = figure.add_subplot()
        line, _ = joined(path, np.zeros(6, bool), 1.0)
        draw_joined(panel, *line, color="black")
        return np.isfinite(panel.lines[0].get_xdata()).all(), sum(len(item.get_xdata()) for item in panel.lines[1:])

    assert drawn(100.0, 0.0) == (False, 6)
    assert drawn(30.0, 0.0) == drawn(100.0, 1.05) == (True, 0)


@pytest.mark.parametrize(
    "left_out", slow_but_first([("disturbance_cycle", "relief_cycle"), (), ("relief_cycle",), ("disturbance_cycle",)])
)
def test_every_figure_is_drawn_from_the_data_set_alone(synthetic, without, tmp_path, left_out):
    figures = json.dumps([*USUAL, "whirl", "energy"])
    dataset = without(synthetic(plot_figures=figures), *left_out)
    assert drawn(dataset, tmp_path) == json.loads(figures)


def test_a_title_has_speeds_in_a_single_unit(synthetic):
    """Scenarios state speeds as their source does; a title beside its own speed in rpm has no rad/s."""
    dataset = synthetic().assign_attrs(description="lost at 260 rad/s: it loses 7 rad/s")
    title = plots.figure(dataset, "orbits").get_suptitle().split("\n", 1)[1]
    assert_names(title, f"{260.0 * RPM:.0f} rpm", "66.85 rpm")
    assert "rad/s" not in title
    with amb_cosim.units("rad/s"):
        assert "260 rad/s" in plots.figure(dataset, "orbits").get_suptitle()


def test_a_run_that_rolls_shows_its_whirl(synthetic, tmp_path):
    dataset = synthetic()
    dataset["rotor_contact.rb1.mode"] = dataset["rotor_contact.rb1.mode"] * 2
    assert drawn(dataset, tmp_path) == [*USUAL, "whirl"]


def test_a_rotor_that_rolls_while_it_lies_on_a_face_shows_its_whirl(synthetic):
    """A face has no whirl: neither the figure nor the panels of a page have a curve of it, and they are drawn."""
    dataset = synthetic(places=replace(PLACES, faces={"seat": "rb1"}).to_json())
    dataset["rotor_contact.seat.f_n"] = ("time", np.full(dataset.sizes["time"], 900.0))
    dataset["rotor_contact.seat.mode"] = ("time", np.full(dataset.sizes["time"], 2))
    alone = dataset.assign(
        {
            f"rotor_contact.rb{i}.{name}": ("time", np.zeros(dataset.sizes["time"]))
            for i in (1, 2)
            for name in ("f_n", "impulse", "mode")
        }
    )
    with raises_naming(ValueError, "whirl", "touched"):
        plots.figure(alone, "whirl")
    dataset["rotor_contact.rb1.mode"] = dataset["rotor_contact.rb1.mode"] * 2
    for name in plots.chosen(dataset):
        figure = plots.figure(dataset, name)
        if name == "whirl":
            assert [axes.get_title("left") for axes in figure.axes[::2]] == ["Retainer RB1", "Retainer RB2"]
    (whirl,) = [panel for panel in run_panels(dataset) if panel.title == "Whirl speed"]
    assert {of.name for of in whirl.curves} == {"RB1", "RB2"}


def test_a_changing_speed_is_drawn_over_time(synthetic, tmp_path):
    dataset = synthetic(**profile((0.0, 20.0), (0.1, 20.0), (0.3, 60.0)))
    assert drawn(dataset, tmp_path) == ["displacement", "contact"]
    figure = motion.displacement(dataset)
    *_, below = figure.axes
    (line,) = below.lines[:1]
    assert below.get_xlabel() == "time (s)"
    assert below.get_xlim() == pytest.approx((0.0, 0.4))
    assert np.interp([0.05, 0.2, 0.35], *line.get_data()) == pytest.approx([20.0 * RPM, 40.0 * RPM, 60.0 * RPM])


def test_figure_of_a_touchdown_shows_races_and_temperatures(tmp_path):
    dataset = fall()
    assert drawn(dataset, tmp_path) == ["touchdown", "displacement", "contact"]
    figure = plots.Plots(dataset).touchdown()
    orbit, _, heights, speeds, heat, temperatures = figure.axes
    assert orbit.get_xlim() == pytest.approx((-0.81, 0.81))
    assert heat.get_ylabel() == "heat (J)"
    fallen, *_ = heights.lines
    assert np.interp(LANDED, *fallen.get_data()) == pytest.approx(-1e3 * CLEARANCE)
    assert temperatures.get_ylabel() == "temperature (°C)"
    spin, race, _ = speeds.lines
    assert np.interp([1.1, 2.9], *spin.get_data()) == pytest.approx([0.5 * OMEGA * RPM, 0.0], abs=10.0)
    assert race.get_ydata().max() == pytest.approx(100.0 * RPM)


@pytest.mark.parametrize("gravity", [9.81, 0.0])
def test_names_of_events_are_below_the_title_of_a_touchdown(gravity):
    """The first panel over time shows heights, or the speeds of an upright machine, whose event is at its left end."""
    dataset = fall(gravity)
    dataset.attrs |= {"disturbance_cycle": 0.0}
    figure = plots.Plots(dataset).touchdown()
    figure.canvas.draw()
    panel = figure.axes[2]
    (event,) = panel.texts
    title = next(text for text in panel.findobj(Text) if text.get_text() == panel.get_title("left"))
    assert not event.get_window_extent().overlaps(title.get_window_extent())


@pytest.mark.parametrize("samples", slow_but_first([1, 0, 2, None]))
def test_shortest_runs_and_one_that_failed_while_settling_can_be_drawn(synthetic, tmp_path, samples):
    dataset = synthetic(1, plot_figures=json.dumps([*USUAL, "whirl", "energy"]))
    if samples is None:
        dataset = dataset.assign_coords(cycle=dataset["cycle"] - 8.0)
    plots.draw_all(dataset.isel(time=slice(0, samples)), tmp_path)


def test_adjacent_parts_of_a_run_share_a_sample(synthetic):
    parts = motion.run_parts(synthetic())
    assert [name for name, _, _ in parts] == ["before the step", "from the step on", "after the removal"]
    covered = sum(within.astype(int) for _, _, within in parts)
    assert covered.min() == 1
    assert np.flatnonzero(covered == 2).tolist() == [500, 1000]


def test_figures_that_cannot_be_drawn_are_refused(synthetic):
    dataset = synthetic()
    with raises_naming(ValueError, "figure", "'orbit'", "orbits, displacement"):
        plots.figure(dataset, "orbit")
    with raises_naming(ValueError, "contact", "no sample"):
        plots.figure(dataset.isel(time=slice(0, 0)), "contact")
    with raises_naming(ValueError, "touchdown", "gravity", "contact"):
        plots.Plots(dataset).touchdown()
    with raises_naming(ValueError, "energy", "cycle 0"):
        plots.Plots(dataset.drop_vars("rotor_contact.energy.work")).energy()


def test_vertical_is_vertical_in_orbits(synthetic):
    """Gravity at 225 degrees, halfway between -x and -y: motion along x is to the upper right."""
    dataset = synthetic(parameters=synthetic().attrs["parameters"].replace('{"rotor_contact": {', GRAVITY))
    dataset["rotor_contact.mb1.x"] = ("time", np.linspace(0.0, 5e-4, dataset.sizes["time"]))
    dataset["rotor_contact.mb1.y"] = dataset["rotor_contact.mb1.x"] * 0.0
    panel = plots.Plots(dataset).orbits().axes[0]
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("to the right (mm)", "up (mm)")
    x, y = panel.lines[2].get_data()
    assert np.nanmax(x) == pytest.approx(0.5 / np.sqrt(2.0))
    assert np.nanmax(y) == pytest.approx(0.5 / np.sqrt(2.0))
    assert [text.get_text() for text in panel.texts] == ["$x$", "$y$"]


GRAVITY = '{"rotor_contact": {"gravity": 9.81, "gravity_angle": 3.9269908169872414, '


def lines_of(axes):
    """Values of the lines of some axes, by label."""
    return {line.get_label(): np.asarray(line.get_ydata(), float) for line in axes.lines}


def test_contact_between_samples_is_an_arc():
    """Samples 100 degrees apart, backward, all in contact: a chord would pass at 0.64 of the clearance."""
    angles = np.radians(-100.0) * np.arange(40)
    path = 0.75e-3 * np.array([np.cos(angles), np.sin(angles)])
    line, sample = joined(path, np.ones(40, bool), 0.75e-3)
    np.testing.assert_allclose(np.hypot(*line), 0.75e-3, rtol=1e-12)
    np.testing.assert_allclose(line[:, np.flatnonzero(np.diff(sample, prepend=-1))], path, atol=1e-12)
    turned = np.unwrap(np.arctan2(line[1], line[0]))
    assert np.all(np.diff(turned) < 0.0)
    assert turned[-1] - turned[0] == pytest.approx(angles[-1])


@pytest.mark.parametrize(("turned", "covered"), [(90.0, 90.0), (-270.0, -270.0), (450.0, 450.0)])
def test_arc_of_contact_follows_the_whirl_where_it_is_known(turned, covered):
    """A quarter turn forward may be three quarters backward."""
    path = np.array([[1.0, 0.0], [0.0, 1.0]])
    line, _ = joined(path, np.ones(2, bool), 1.0, np.radians([turned]))
    angle = np.unwrap(np.arctan2(line[1], line[0]))
    assert np.degrees(angle[-1] - angle[0]) == pytest.approx(covered)


def test_samples_without_contact_are_joined_unless_they_are_far_apart():
    """At 0.9 of the clearance 60 degrees apart nobody knows the path; through the centre it is straight."""
    far = 0.9 * np.array([[1.0, 0.5], [0.0, 0.75**0.5]])
    line, sample = joined(far, np.array([True, False]), 1.0)
    assert np.isnan(line[:, 1]).all()
    assert sample.tolist() == [0, 0, 1]
    for near in (0.3 * far, np.array([[0.9, -0.3], [0.0, 0.0]]), 0.9 * np.array([[1.0, 0.8], [0.0, 0.6]])):
        assert np.array_equal(joined(near, np.zeros(2, bool), 1.0)[0], near)


@pytest.mark.parametrize(
    "draw",
    [
        motion.orbits,
        touchdown,
        lambda dataset: overlays({"a": dataset, "b": dataset})["orbits"],
    ],
    ids=["orbits", "touchdown", "compare"],
)
def test_orbit_is_drawn_along_the_clearance_in_contact(synthetic, draw):
    """Thinned to 30 samples a turn of the rotor, which whirls 3 times as fast in contact."""
    dataset = synthetic()
    cycle = dataset["cycle"].values
    dataset["rotor_contact.mb1.x"] = ("time", 0.75e-3 * np.cos(6.0 * np.pi * cycle))
    dataset["rotor_contact.mb1.y"] = ("time", 0.75e-3 * np.sin(6.0 * np.pi * cycle))
    dataset["rotor_contact.rb1.mode"] = ("time", np.ones(len(cycle), np.int32))
    dataset["rotor_contact.rb1.whirl_speed"] = ("time", np.full(len(cycle), 6.0 * np.pi / 0.02))
    drawn_orbit = draw(dataset.isel(time=slice(None, None, 9))).axes[0]
    radii = [np.hypot(*np.asarray(line.get_data(), float)) for line in drawn_orbit.lines]
    paths = [r[np.isfinite(r)] for r in radii if len(r) > 100]
    assert paths
    assert np.concatenate(paths) == pytest.approx(0.75, rel=1e-6)


def test_no_current_is_drawn_while_the_amplifier_is_off(synthetic):
    """From cycle 5 to 10 the controller demands a current that does not flow."""
    dataset = synthetic()
    off = (dataset["cycle"].values >= 5.0) & (dataset["cycle"].values < 10.0)
    for bearing, axis in ((b, a) for b in ("mb1", "mb2") for a in "xy"):
        dataset[f"rolac_controller.{bearing}.i_{axis}"] = ("time", np.full(len(off), 3.0))
        dataset[f"amb_actuator.{bearing}.f_{axis}"] = ("time", np.where(off, 0.0, 30.0))
        dataset[f"amb_actuator.{bearing}.amplifier_off_{axis}"] = ("time", off & (bearing == "mb1"))
    axes = plots.Plots(dataset).magnets().axes
    for panel, expected in ((axes[0], np.where(off, np.nan, 3.0)), (axes[2], np.full(len(off), 3.0))):
        for line in panel.lines[:2]:
            np.testing.assert_array_equal(line.get_ydata(), expected)
    first, last = axes[0].collections[0].get_paths()[0].get_extents().intervalx
    assert (first, last) == pytest.approx((5.0, 9.99))


def magnet_run(dataset, off, current, force):
    """A run whose bearing MB1 is off at some samples; MB2 has no current and no force."""
    for axis in "xy":
        for bearing, on in (("mb1", 1.0), ("mb2", 0.0)):
            dataset[f"rolac_controller.{bearing}.i_{axis}"] = ("time", np.full(len(off), current * on))
            dataset[f"amb_actuator.{bearing}.f_{axis}"] = ("time", force * on * np.where(off, 0.01, 1.0))
            dataset[f"amb_actuator.{bearing}.amplifier_off_{axis}"] = ("time", off)
    return dataset


@pytest.mark.parametrize("total", [True, False])
def test_magnets_state_the_demand_and_what_the_force_excludes(synthetic, total):
    """A demanded current may not flow; with `total_force`, the force includes the static load."""
    dataset = synthetic()
    run = magnet_run(dataset, np.zeros(dataset.sizes["time"], bool), 3.0, 30.0)
    values = json.loads(run.attrs["parameters"]) | {"amb_actuator": {"total_force": total}}
    current, force = plots.Plots(run.assign_attrs(parameters=json.dumps(values))).magnets().axes[:2]
    assert "demanded" in current.get_title("left")
    assert ("static load" in force.get_title("left")) is not total


def test_a_run_without_power_has_no_figure_of_its_magnets(synthetic):
    """The controller demands a current all the time; none flows."""
    dataset = synthetic()
    steps = dataset.sizes["time"]
    assert "magnets" in plots.chosen(magnet_run(dataset, np.zeros(steps, bool), 3.0, 30.0))
    assert "magnets" not in plots.chosen(magnet_run(dataset, np.ones(steps, bool), 3.0, 30.0))


def test_current_of_rounding_has_no_scale_of_its_own(synthetic):
    dataset = synthetic()
    powered = np.zeros(dataset.sizes["time"], bool)
    panel = plots.Plots(magnet_run(dataset, powered, 4e-16, 30.0)).magnets().axes[0]
    assert panel.get_ylim() == pytest.approx((-1.0, 1.0))


def test_limits_that_are_written_alike_are_written_once():
    panel = StyledFigure().subplots()
    _draw_limits(panel, [(-5.13611, 4.0), (-5.13612, 4.0)], [np.array([0.1, -0.1])], 1.0, "A")
    (text,) = panel.texts
    assert text.get_text().count("5.136") == 1


@pytest.mark.parametrize(("law", "heat"), [(0.0, False), (1.0, True)])
def test_energy_of_impacts_is_heat_unless_the_rule_is_nodal(synthetic, law, heat):
    """The nodal rule does not conserve momentum, and may create energy."""
    dataset = synthetic()
    values = json.loads(dataset.attrs["parameters"])["rotor_contact"] | {"contact.impact_law": law}
    figure = plots.Plots(dataset.assign_attrs(parameters=json.dumps({"rotor_contact": values}))).energy()
    [label] = [name for name in lines_of(figure.axes[1]) if "impact" in name]
    assert ("heat" in label) is heat
    assert ("nodal" in label) is not heat
    balance, damping, friction = (
        next(line for line in figure.axes[1].lines if name in str(line.get_label()))
        for name in ("balance error", "damping", "friction")
    )
    assert damping.get_linewidth() > friction.get_linewidth() > balance.get_linewidth()


@pytest.mark.parametrize(
    ("free", "expected"), [(1.0, {"spin": 13520.0, "lateral kinetic": 10.0}), (0.0, {"kinetic": 13530.0})]
)
def test_energy_of_a_free_spin_is_not_drawn_as_that_of_the_lateral_motion(synthetic, free, expected):
    """1/2 I_p Omega^2 of 0.4 kg m2 at 260 rad/s are 13.52 kJ, of 13.53 kJ of kinetic energy."""
    dataset = synthetic()
    count = dataset.sizes["time"]
    dataset["rotor_contact.speed"] = ("time", np.full(count, 260.0))
    dataset["rotor_contact.energy.kinetic"] = ("time", np.full(count, 13530.0))
    values = json.loads(dataset.attrs["parameters"])["rotor_contact"]
    plant = values | {"spin.free": free, "spin.inertia": 0.4}
    stored = plots.Plots(dataset.assign_attrs(parameters=json.dumps({"rotor_contact": plant}))).energy().axes[0]
    lines = lines_of(stored)
    assert {name: lines[name][5] for name in expected} == pytest.approx(expected)
    assert ("spin" in stored.get_title(loc="left")) is bool(free)
