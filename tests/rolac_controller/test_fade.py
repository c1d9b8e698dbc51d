"""ROLAC's force fades, without a step, when ROLAC is switched off or becomes inactive."""

import math
from functools import partial

import numpy as np
import pytest
from controller_bench import SAMPLES
from controller_bench import synchronous as signal

from rolac_controller.enumerations import ADAPTING, NO_H, NO_WINDOW, OFF, SENSOR_SUSPECT, TOO_SLOW

H = 250e-6
FADE = 20.0  # 1/s


@pytest.fixture
def running(adapting):
    """A controller without PID gains whose ROLAC has built up a force; its currents are that force alone."""
    return partial(adapting, 10, pid=False)


def switch_off(b):
    b["rolac_enable"] = 0.0


def run_too_slow(b):
    b["rolac.min_speed"] = 2.0 * b["Omega"]


def leave_the_table(b):
    b["rolac.extrapolate"] = 0.0


def break_a_sensor(b):
    b["s3.fault_dead"] = 1.0
    b.follow(signal, SAMPLES)


def turn_the_mark(b):
    b.theta += 2.0


LOSSES = [
    (switch_off, OFF),
    (run_too_slow, TOO_SLOW),
    (leave_the_table, NO_H),
    (break_a_sensor, SENSOR_SUSPECT),
    (turn_the_mark, NO_WINDOW),
]


@pytest.mark.parametrize(("lose", "status"), LOSSES, ids=[lose.__name__ for lose, _ in LOSSES])
def test_force_changes_by_no_more_than_rate_times_sample(running, lose, status):
    """Apart from the rotation with the rotor, which continues even if its mark jumps."""
    b = running()
    lose(b)
    jump = 2.0 if lose is turn_the_mark else 0.0
    while b["rolac_status"] == ADAPTING:
        before = b.forces()
        turned = before * np.exp(1j * (b.theta - jump))
        b.follow(signal, 1)
    assert b["rolac_status"] == status
    np.testing.assert_allclose(np.angle(b.forces() / before), -jump, atol=1e-9)
    assert np.abs(before).min() > 1.0
    change = b.axis_forces() - turned.real
    assert np.all(np.abs(change) <= FADE * H * np.abs(before) * (1.0 + 1e-9))


def test_force_fades_with_the_rate_of_its_parameter(running):
    b = running()
    b["rolac.fade"] = 100.0
    at_first = b.forces()
    b["rolac_enable"] = 0.0
    b.follow(signal, 40)
    np.testing.assert_allclose(b.forces(), at_first * (1.0 - 100.0 * H) ** 40, rtol=1e-9)
    assert np.abs(b.forces() / at_first) == pytest.approx(math.exp(-1.0), rel=0.02)
    b.follow(signal, 2000)
    assert not b.forces().any()


def test_rolac_resumes_from_the_faded_force(running):
    """The final force is as large as without the pause, less the missed adaptation and the faded part."""
    b = running()
    growth = np.abs(b.forces()).max() / (9 * SAMPLES)  # per sample; the signal does not heed the force
    b["rolac_enable"] = 0.0
    b.follow(signal, 100)
    left = b.forces()
    assert np.abs(left).min() > 0.0
    b["rolac_enable"] = 1.0
    b.follow(signal, 1)
    assert 0.0 < np.abs(b.forces() - left).max() < 1.1 * growth


def test_fast_fade_ends_the_force_at_once(running):
    b = running(rolac__fade=1.0 / H)
    b["rolac_enable"] = 0.0
    b.follow(signal, 1)
    assert not b.forces().any()
