"""The overload at which a rotor touches its retainers."""

from types import SimpleNamespace

import numpy as np
import pytest

from amb_assessment.assessment.analyses import recovery
from amb_cosim.scenario.gravity import STANDARD_GRAVITY

LYING = SimpleNamespace(directions_of_contact="xy")


class QuasiStatic:
    """Runs of a rotor that touches at an acceleration of the base (g), without dynamics, in steps of 1 ms."""

    def __init__(self, touches_at, monkeypatch):
        self.touches_at = touches_at
        monkeypatch.setattr(recovery, "simulate", self.simulate)
        monkeypatch.setattr(recovery, "times_of", lambda run: run[0])
        monkeypatch.setattr(recovery, "clearance_used", lambda subject, run: {"catcher": run[1]})

    def simulate(self, subject, Omega, inputs, *, to_magnets, levitated, end_time, event):
        assert levitated
        times = 1e-3 * np.arange(1, round(1e3 * end_time) + 1)  # ends of steps
        base = np.zeros(len(times))
        for change in event:
            (acceleration,) = change["set"]["rotor_contact"].values()
            base[times > change["time"] + 1e-9] = abs(acceleration) / STANDARD_GRAVITY
        return times, np.minimum(base / self.touches_at, 1.0)


@pytest.mark.parametrize("touches_at", [0.25, 3.0, 7.75, 8.0])
def test_overload_is_the_acceleration_that_touches(touches_at, monkeypatch):
    QuasiStatic(touches_at, monkeypatch)
    overload, _ = recovery._overload(LYING, 100.0, {})
    assert overload.value == pytest.approx(touches_at)
    assert "touched first" in overload.where


def test_a_rotor_that_survives_the_last_overload_has_no_contact(monkeypatch):
    QuasiStatic(8.01, monkeypatch)
    overload, (_, used) = recovery._overload(LYING, 100.0, {})
    assert overload.value == 8.0
    assert overload.where == "no contact"
    assert np.isclose(used, 8.0 / 8.01).sum() == 20  # ms


def test_the_first_of_directions_that_agree_is_named(monkeypatch):
    """Rounding of the displacement does not choose the direction."""
    runs = {"x": (0.75, -1.02), "y": (0.75, -1.02 - 1e-12)}
    monkeypatch.setattr(recovery, "_rising", lambda *given: (*runs[given[3]], given[3] + given[4], None))
    overload, _ = recovery._overload(SimpleNamespace(directions_of_contact="xy"), 100.0, {})
    assert overload == "x+"
