"""Figures of a synthetic run: which are drawn, and their content."""

import json

import numpy as np
import pytest
from falls import CLEARANCE, LANDED, OMEGA, fall
from matplotlib.text import Text
from slow import slow_but_first

from amb_cosim.results import plots
from amb_cosim.results.plots import motion
from tests.support.messages import raises_naming

USUAL = ["orbits", "displacement", "contact"]


def profile(*points):
    return {"speed_profile": json.dumps(points)}


def drawn(dataset, folder):
    paths = plots.draw_all(dataset, folder)
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in paths)
    return [p.stem for p in paths]


@pytest.mark.parametrize(
    "left_out", slow_but_first([("disturbance_cycle", "relief_cycle"), (), ("relief_cycle",), ("disturbance_cycle",)])
)
def test_every_figure_is_drawn_from_the_data_set_alone(synthetic, without, tmp_path, left_out):
    figures = json.dumps([*USUAL, "whirl", "energy"])
    dataset = without(synthetic(plot_figures=figures), *left_out)
    assert drawn(dataset, tmp_path) == json.loads(figures)


def test_a_run_that_rolls_shows_its_whirl(synthetic, tmp_path):
    dataset = synthetic()
    dataset["rotor_contact.rb1.mode"] = dataset["rotor_contact.rb1.mode"] * 2
    assert drawn(dataset, tmp_path) == [*USUAL, "whirl"]


def test_a_changing_speed_is_drawn_over_time(synthetic, tmp_path):
    dataset = synthetic(**profile((0.0, 20.0), (0.1, 20.0), (0.3, 60.0)))
    assert drawn(dataset, tmp_path) == ["displacement", "contact"]
    figure = motion.displacement(dataset)
    *_, below = figure.axes
    (line,) = below.lines[:1]
    assert below.get_xlabel() == "time (s)"
    assert below.get_xlim() == pytest.approx((0.0, 0.4))
    assert np.interp([0.05, 0.2, 0.35], *line.get_data()) == pytest.approx([20.0, 40.0, 60.0])


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
    assert np.interp([1.1, 2.9], *spin.get_data()) == pytest.approx([0.5 * OMEGA, 0.0], abs=1.0)
    assert race.get_ydata().max() == 100.0


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


def test_a_run_without_gravity_has_no_touchdown_to_draw(synthetic):
    with raises_naming(ValueError, "touchdown", "gravity", "contact"):
        plots.Plots(synthetic()).touchdown()


@pytest.mark.parametrize("samples", slow_but_first([1, 0, 2]))
def test_the_shortest_runs_can_be_drawn(synthetic, tmp_path, samples):
    dataset = synthetic(plot_figures=json.dumps([*USUAL, "whirl", "energy"]))
    plots.draw_all(dataset.isel(time=slice(0, samples)), tmp_path)


def test_a_run_that_failed_while_settling_can_be_drawn(synthetic, tmp_path):
    dataset = synthetic(1, plot_figures=json.dumps([*USUAL, "whirl", "energy"]))
    plots.draw_all(dataset.assign_coords(cycle=dataset["cycle"] - 8.0), tmp_path)


def test_adjacent_parts_of_a_run_share_a_sample(synthetic):
    parts = motion.run_parts(synthetic())
    assert [name for name, _, _ in parts] == ["before the step", "from the step on", "after the removal"]
    covered = sum(within.astype(int) for _, _, within in parts)
    assert covered.min() == 1
    assert np.flatnonzero(covered == 2).tolist() == [500, 1000]


# Figures in Python and in a notebook


def test_figures_that_cannot_be_drawn_are_refused(synthetic):
    dataset = synthetic()
    with raises_naming(ValueError, "figure", "'orbit'", "orbits, displacement"):
        plots.figure(dataset, "orbit")
    with raises_naming(ValueError, "contact", "no sample"):
        plots.figure(dataset.isel(time=slice(0, 0)), "contact")
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
