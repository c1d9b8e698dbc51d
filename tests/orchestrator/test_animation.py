"""Animations of a run's orbits: pictures, their moments, formats, and what is refused."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from PIL import Image

from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.results.animation import Scene, frame_cycles
from amb_cosim.results.result import Result


@pytest.fixture
def saved(synthetic, tmp_path):
    """Folder of a saved run of 20 cycles."""
    dataset = synthetic(outcome=json.dumps(["completed", 0.4, None, ""]))
    return Result(dataset, Outcome("completed", 0.4)).save(tmp_path / "run", plots=False)


def test_animation_has_a_picture_for_each_moment(saved, runner, tmp_path):
    result = runner("animate", "run", "--begin", "6", "--end", "7", "--frames-per-cycle", "5")
    assert result.exit_code == 0, result.output
    assert "animation in run/orbits.gif" in result.stdout
    with Image.open(tmp_path / "run" / "orbits.gif") as animation:
        assert animation.n_frames == 6
        assert animation.info["duration"] == 40  # ms, at 25 pictures a second
        first = np.asarray(animation.convert("L"))
        animation.seek(3)
        later = np.asarray(animation.convert("L"))
    assert (first < 250).mean() > 0.01
    assert (first != later).any()


def test_moments_are_evenly_spaced_cycles_of_the_run(synthetic):
    run = synthetic(end=4)
    assert frame_cycles(run, 1.0, 3.0, 2.0) == pytest.approx([1.0, 1.5, 2.0, 2.5, 3.0])
    assert len(frame_cycles(run, None, None, 10.0)) == 41


def test_scene_shows_place_trail_and_contact_force(synthetic):
    """RB1 is touched from cycle 6 to 7.5, with 1 kN; MB1 is at a whole cycle on the x axis, at 0.5 mm."""
    scene = Scene(synthetic(), trail=0.25)
    scene.show(7.0)
    _, _, _, line, dot, text, _ = scene.drawn[0]
    assert dot.get_xydata() == pytest.approx(np.array([[0.5, 0.0]]), abs=1e-9)
    assert len(line.get_xydata()) == 26  # 100 samples a cycle
    assert text.get_text() == "1.00 kN"
    scene.show(9.0)
    assert text.get_text() == ""


def test_mp4_without_ffmpeg_is_refused(saved, refuses, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    refuses("the program ffmpeg, which writes .mp4, is not installed", "animate", "run", "-o", "orbits.mp4")
