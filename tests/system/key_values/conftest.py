"""Ten short runs, one of each kind, each run once per test session."""

import sys
from functools import cache
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from waveforms import Record

import amb_cosim
from amb_cosim.scenario.scenario import load_scenario

ACROSS_A_RESONANCE = {
    "Omega": "10 Hz",
    "end_time": "1.2 s",
    "speed": [{"time": "0.1 s", "Omega": "10 Hz"}, {"time": "0.9 s", "Omega": "25 Hz"}],
    "record": {"every": 1},
}
WARM = {"rotor_contact.rb?.heat_capacity": "150 J/K", "rotor_contact.rb?.heat_transfer": "40 W/K"}
RUNS = {  # scenario, what is changed in it, end (s), parameters
    "levitation": ("compressor_levitated", {}, 0.06, {}),
    "rub": ("fig4_9", {}, None, {"rotor_contact.rb?.mu": 0.1}),
    "rolling": ("rolling_90", {}, None, {}),
    "landing": ("drop_race", {}, 0.25, WARM),
    "run-up": ("run_up", ACROSS_A_RESONANCE, None, {}),
    "base shock": ("base_shock", {}, 0.15, {}),
    "upright landing": ("turbo_pump_landing", {}, 0.08, {}),
    "sensor loss": ("sensor_lost", {}, 0.1, {}),
    "whirl": ("drop_whirl", {}, 0.1, {}),
    "standstill": ("drop", {"Omega": "10 rad/s"}, 0.6, {"rotor_contact.*.mu": 0.5}),
}


@cache
def _run(kind: str) -> Record:
    name, changes, until, values = RUNS[kind]
    return Record(amb_cosim.run(load_scenario(name).changed(**changes), until=until, set=values, progress=False))


@pytest.fixture(params=RUNS)
def record(request: pytest.FixtureRequest) -> Record:
    """The record and the summary of each of the ten runs."""
    return _run(request.param)


@pytest.fixture
def record_of():
    """`record_of(kind)`: the record and the summary of one of the ten runs."""
    return _run
