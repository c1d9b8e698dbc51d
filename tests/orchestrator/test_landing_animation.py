"""A landing in slow motion: its pace, the ring on its mount, the force on the rotor, and the file."""

import re

import numpy as np
import pytest
from falls import CLEARANCE, LANDED, RELEASE, fall
from PIL import Image

from amb_cosim.results.plots import landing as module
from amb_cosim.results.plots.landing import landing, write_landing
from tests.support.messages import raises_naming


def shown(dataset, frame, **limits):
    figure, animation = landing(dataset, **limits)
    animation._func(frame)
    animation._draw_was_started = True  # no warning that it was never played
    return {axes.get_label(): axes for axes in figure.axes}


def test_slow_motion_states_its_pace_and_the_time_since_the_loss_of_power():
    """From 0.1 s after the release on, 0.2 s in 100 frames at 15 per second are shown in 6.6 s: 33 times slower."""
    title = shown(fall(), 99, begin=RELEASE + 0.1, until=RELEASE + 0.3)["shaft"].get_title("left")
    after, slower = re.search(r"([\d.]+) ms after .* (\d+) times slower", title).groups()
    assert float(after) == pytest.approx(300.0, abs=1.0)
    assert float(slower) == pytest.approx(99 / 15 / 0.2, abs=0.5)


def test_force_on_a_fallen_rotor_points_up_and_is_zero_in_flight():
    lying = shown(fall(), 99, begin=2.0, until=2.5)["rb1"]
    (force,) = [item for item in lying.collections if hasattr(item, "U")]
    right, up = float(force.U[0]), float(force.V[0])
    (centre,) = [line for line in lying.lines if line.get_marker() == "o"]
    x, y = (float(values[0]) for values in centre.get_data())
    assert np.hypot(x, y) == pytest.approx(1e3 * CLEARANCE)
    assert right * x + up * y == pytest.approx(-np.hypot(right, up) * np.hypot(x, y))
    assert "N" in lying.texts[-1].get_text()
    flying = shown(fall(), 1, begin=RELEASE, until=LANDED - 0.01)["rb1"]
    (force,) = [item for item in flying.collections if hasattr(item, "U")]
    assert float(np.hypot(force.U[0], force.V[0])) == 0.0


def test_ring_and_rotor_move_with_the_mount():
    """A housing at 0.2 mm upwards carries the ring; the rotor is 0.75 mm below its centre after the landing."""
    t = fall()["time"].values
    up = 0.2e-3 * (t > 2.0)
    moved = {f"rb1.housing_{axis}": np.sqrt(0.5) * up for axis in "xy"}
    panel = shown(fall(**moved), 99, begin=2.1, until=2.5)["rb1"]
    (ring,) = panel.patches
    (centre,) = [line for line in panel.lines if line.get_marker() == "o"]
    rotor = np.array([float(values[0]) for values in centre.get_data()])
    assert np.hypot(*ring.get_center()) == pytest.approx(0.2, rel=1e-6)
    assert ring.get_center()[1] == pytest.approx(0.2, rel=1e-6)
    assert rotor[1] <= 0.2


def test_file_is_an_animation_that_repeats(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "FRAMES", 3)
    write_landing(fall(), tmp_path / "landing.gif")
    with Image.open(tmp_path / "landing.gif") as picture:
        assert picture.n_frames == 3
        assert picture.info["loop"] == 0


def test_film_without_ffmpeg_and_run_without_a_landing_are_refused(tmp_path, monkeypatch, synthetic):
    monkeypatch.setattr(module, "FRAMES", 3)
    monkeypatch.setattr(module.FFMpegWriter, "isAvailable", lambda: False)
    with raises_naming(ValueError, "ffmpeg", ".gif"):
        write_landing(fall(), tmp_path / "landing.mp4")
    with raises_naming(ValueError, "retainer", "orbits"):
        write_landing(synthetic(), tmp_path / "landing.gif")
    without_scenario = fall()
    del without_scenario.attrs["scenario"]
    with raises_naming(ValueError, "scenario"):
        write_landing(without_scenario, tmp_path / "landing.gif")
    with raises_naming(ValueError, "motion"):
        write_landing(fall().isel(time=slice(0, 0)), tmp_path / "landing.gif")
    with raises_naming(ValueError, "sample", "2"):
        write_landing(fall(), tmp_path / "landing.gif", begin=1.0, until=1.0)
    assert list(tmp_path.iterdir()) == []
