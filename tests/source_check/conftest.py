"""A synthetic run with known quantities, and statements about it."""

import json

import numpy as np
import pytest

from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.results.places import RotorPlaces

PERIOD, SAMPLES, END = 0.02, 100, 20.0  # s, of a cycle, cycles
CLEARANCE = 0.75e-3
RB1, RB2 = (6.0, 9.0), (7.0, 8.0)  # cycles in contact
ROLLS_FROM = 8.0


@pytest.fixture(scope="session")
def known_run() -> SignalTable:
    """RB1 is touched from cycle 6 to 9 with 3 kN, RB2 from 7 to 8 with 2 kN; RB1 rolls from cycle 8 on at -3000 rad/s.

    Orbits of 0.1 mm at MB1 and 0.2 mm at MB2 before the step at cycle 5, half as large after.
    """
    cycle = np.arange(0.0, END, 1.0 / SAMPLES)
    at1, at2 = ((cycle >= begin) & (cycle < end) for begin, end in (RB1, RB2))
    size = np.where(cycle < 5.0, 1.0, 0.5)
    values = {
        "contact_state": at1 * 1 + at2 * 2,
        "rb1.f_n": 3000.0 * at1,
        "rb2.f_n": 2000.0 * at2,
        "rb1.mode": at1 * np.where(cycle >= ROLLS_FROM, 2, 1),
        "rb2.mode": at2 * 1,
        "rb1.whirl_speed": np.where(cycle >= ROLLS_FROM, -3000.0, 100.0) * at1,
        "rb2.whirl_speed": 0.0 * cycle,
        "rb1.impulse": 0.0 * cycle,
        "rb2.impulse": 0.0 * cycle,
    }
    angle = 2.0 * np.pi * cycle
    for bearing, amplitude in (("mb1", 1e-4), ("mb2", 2e-4)):
        values |= {f"{bearing}.x": amplitude * size * np.cos(angle), f"{bearing}.y": amplitude * size * np.sin(angle)}
    attributes = {
        "places": RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2")).to_json(),
        "parameters": json.dumps({"rotor_contact": {"rb1.clearance": CLEARANCE, "rb2.clearance": CLEARANCE}}),
        "period_s": PERIOD,
        "speed_rad_s": 2.0 * np.pi / PERIOD,
        "disturbance_cycle": 5.0,
        "relief_cycle": 10.0,
        "disturbance_label": "step",
        "relief_label": "removal",
    }
    coordinates = {"time": Samples(cycle * PERIOD, {}), "cycle": Samples(cycle, {})}
    return SignalTable({f"rotor_contact.{n}": Samples(v, {}) for n, v in values.items()}, coordinates, attributes)


@pytest.fixture
def statement():
    """`statement(value=..., tolerance=...)`: a statement about a run."""
    from source_check.statements import Statement

    def make(**fields):
        basis = {"key": "fig4_9.force", "where": "Fig. 4.9", "what": "force", "source": "run", "quantity": "peak_force"}
        return Statement(**(basis | fields))

    return make
