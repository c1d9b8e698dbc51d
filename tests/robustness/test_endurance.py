"""Ten minutes of sliding and of levitation, two of rolling: 2.4 million steps, after which nothing has drifted."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from amb_cosim import simulate

pytestmark = pytest.mark.slow

STEPS = 2_400_000
CLEARANCE = 0.75e-3  # m
TURN = 2 * Fraction("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899")
TERMS = ("kinetic", "strain", "damping", "friction", "impact", "work")
SENSORS = range(1, 9)

SLIDING = """
base = "passive"
parameters.rotor_contact = { "initial.orbit" = true, "rb?.mu" = 0.05 }
[experiment]
communication_step = "0.25 ms"
stop_time = "600 s"
record.variables = [PLANT]
record.every = 997
"""
ROLLING = """
base = "passive"
parameters.rotor_contact = { "initial.orbit" = true, "rb?.mu" = 2, "rb2.enabled" = false }
[experiment]
communication_step = "0.05 ms"
stop_time = "120 s"
record.variables = [PLANT]
record.every = 997
"""
LEVITATED = """
base = "levitated"
[experiment]
communication_step = "0.25 ms"
start_time = "-599.5 s"
stop_time = "0.5 s"
record.variables = [PLANT, "rotor_contact.s?", "rolac_controller.*"]
record.settling = false
"""
PLANT = '"rotor_contact.theta", "rotor_contact.rb?.mode", "rotor_contact.mb?.?", "rotor_contact.*energy*"'
# Case, what it starts with, step size (s), steps before the first that is recorded, and from one to the next.
CASES = {
    "sliding": (SLIDING, {"Omega": 120, "rotor_contact.d1.u": 40e-3}, 250e-6, 0, 997),
    "rolling": (ROLLING, {"Omega": 90, "rotor_contact.d1.u": 94e-3}, 50e-6, 0, 997),
    "levitated": (
        LEVITATED,
        {"Omega": 101, "rotor_contact.d1.u": 6.25e-3, "rolac_controller.rolac_enable": True},
        250e-6,
        STEPS - 2000,
        1,
    ),
}


class Endured(NamedTuple):
    """A case: recorded variables, errors of the rotor's angle (rad), memory (bytes) by the share of the run."""

    case: str
    signals: Mapping[str, Any]
    angle_errors: np.ndarray
    memory: list

    def of(self, name):
        return self.signals[name].values


def resident():
    """Memory that this process occupies (bytes)."""
    statistics = Path("/proc/self/statm")
    return int(statistics.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") if statistics.is_file() else 0


@pytest.fixture(scope="module")
def endured(request, tmp_path_factory, cache):
    text, start, h, first, every = CASES[request.param]
    file, memory = tmp_path_factory.mktemp("endurance") / "long.toml", []
    file.write_text(text.replace("PLANT", PLANT))
    run = simulate(file, set=start, progress=lambda done, number: memory.append((done / number, resident())))
    assert (run.outcome.status, memory[-1][0]) == ("completed", 1.0)
    theta = run.signals["rotor_contact.theta"].values
    assert first + every * (len(theta) - 1) > STEPS - every
    errors = []
    for k in range(0, len(theta), max(1, len(theta) // 500)):
        error = Fraction(float(theta[k])) - start["Omega"] * (first + every * k) * Fraction(h)
        errors.append(float((error + TURN / 2) % TURN - TURN / 2))
    return Endured(request.param, run.signals, np.array(errors), memory)


@pytest.mark.parametrize("endured", ["sliding", "rolling"], indirect=True)
def test_journals_stay_on_their_circles(endured):
    """One unit in the last place of the clearance is 1.1e-19 m. The rotor that slides leaves its retainers at times."""
    sites, mode = {"sliding": ((1, 2), 1), "rolling": ((1,), 2)}[endured.case]
    for site in sites:
        closed = endured.of(f"rotor_contact.rb{site}.mode") == mode
        radius = np.hypot(endured.of(f"rotor_contact.mb{site}.x"), endured.of(f"rotor_contact.mb{site}.y"))[closed]
        assert np.mean(closed) > 0.5
        assert np.max(np.abs(radius - CLEARANCE)) < 5e-19


@pytest.mark.parametrize("endured", CASES, indirect=True)
def test_energy_balance_closes_to_the_end(endured):
    largest = np.max(np.abs([endured.of(f"rotor_contact.energy.{term}") for term in TERMS]))
    assert np.max(np.abs(endured.of("rotor_contact.energy.balance"))) < 1e-6 * largest
    assert not np.any(endured.of("rotor_contact.solver.energy_missed"))


@pytest.mark.parametrize("endured", CASES, indirect=True)
def test_rotor_angle_is_speed_times_time(endured):
    assert np.max(np.abs(endured.angle_errors)) < 1e-9


@pytest.mark.skipif(sys.platform != "linux", reason="memory is watched in /proc")
@pytest.mark.parametrize("endured", CASES, indirect=True)
def test_memory_does_not_grow_with_the_steps(endured):
    """Less than a byte for four steps, including the record."""
    sizes = [size for share, size in endured.memory if 0.2 < share < 0.999]
    assert sizes[-1] - sizes[0] < 0.25 * STEPS


def fresh_transform(theta, displacements):
    """Components of the last revolution, (1/pi) integral q exp(-j theta) dtheta, by trapezoids cut at its beginning."""
    theta = np.unwrap(theta)
    first = np.searchsorted(theta, theta[-1] - 2 * math.pi) - 1
    product = displacements[:, first:] * np.exp(-1j * theta[first:])
    width = np.diff(theta[first:])
    excess = theta[-1] - theta[first] - 2 * math.pi
    part = excess / width[0]
    cut = excess * ((1 - 0.5 * part) * product[:, 0] + 0.5 * part * product[:, 1])
    return (np.sum(0.5 * width * (product[:, 1:] + product[:, :-1]), axis=1) - cut) / math.pi


@pytest.mark.parametrize("endured", ["levitated"], indirect=True)
def test_recursive_transform_is_that_of_the_last_revolution(endured):
    theta = endured.of("rotor_contact.theta")
    displacements = np.array([endured.of(f"rotor_contact.s{k}") for k in SENSORS])
    amplitude, phase = (
        np.array([endured.of(f"rolac_controller.{what}.s{k}") for k in SENSORS]) for what in ("amplitude", "phase")
    )
    recursive = amplitude * np.exp(1j * phase)
    errors = [
        np.max(np.abs(fresh_transform(theta[: n + 1], displacements[:, : n + 1]) - recursive[:, n + 1]))
        for n in range(1000, len(theta) - 1)
    ]
    assert np.all(endured.of("rolac_controller.rolac_active") == 1)
    assert max(errors) < 1e-12 * np.max(amplitude)
