"""Each number of `summary.json`, computed anew from the record of every step by other means (`waveforms`)."""

import json

import numpy as np
import pytest
from waveforms import AT_PLACES, OF_RETAINER, OF_RUN, OF_TOUCHDOWN

ROUNDING = {"rel": 1e-9, "abs": 1e-12}
TOLERANCES = {
    "energy_J": {"rel": 1e-9, "abs": 1e-8},
    "energy_balance_relative": {"rel": 1e-3, "abs": 1e-14},
    "energy_balance_of_heat": {"rel": 1e-3, "abs": 1e-12},
    "settled_amplitude_mm": {"rel": 4e-3, "abs": 1e-9},
    "whirl_speed_rad_s": {"rel": 2e-3, "abs": 0.1},
    "share_beyond_reduction": {"rel": 1e-3, "abs": 1e-7},
    "temperature_K": {"rel": 1e-7, "abs": 0.0},
}
NOT_NUMBERS = {  # words, and what only the computer's clock knows
    "scenario", "flavour", "completed", "stopped", "settling", "settling_s", "wall_s", "real_time_factor",
    "steps_by_method", "peak_is_sampled", "events", "event_cycles_cycle", "contact_states", "recovered", "recovery",
    "stators", "touchdown", "warnings", "notices",
}  # fmt: skip
OF_TOUCHDOWN_ELSEWHERE = {"retainers", "rest_after_s", "rocks_within_deg"}


def approx(expected, name):
    if isinstance(expected, dict):
        return {key: approx(value, name) for key, value in expected.items()}
    if isinstance(expected, list):
        return [approx(value, name) for value in expected]
    if expected is None or isinstance(expected, str | bool):
        return expected
    return pytest.approx(expected, **TOLERANCES.get(name, ROUNDING))


def test_every_entry_of_the_summary_is_computed_anew(record):
    assert record.given.keys() == {*AT_PLACES, *OF_RUN, *NOT_NUMBERS}
    if record.given["touchdown"] is not None:
        assert record.given["touchdown"].keys() == {*OF_TOUCHDOWN, *OF_TOUCHDOWN_ELSEWHERE}
        for retainer in record.given["touchdown"]["retainers"].values():
            assert retainer.keys() == {*OF_RETAINER}


@pytest.mark.parametrize("name", AT_PLACES)
def test_a_value_at_places(record, name):
    given = record.given[name]
    assert given == approx({place: AT_PLACES[name](record, place) for place in given}, name)


@pytest.mark.parametrize("name", OF_RUN)
def test_a_value_of_the_run(record, name):
    assert record.given[name] == approx(OF_RUN[name](record), name)


@pytest.mark.parametrize("name", OF_RETAINER)
def test_loads_of_a_retainer(record, name):
    fall = record.given["touchdown"] or {"retainers": {}}
    given = {site: retainer[name] for site, retainer in fall["retainers"].items()}
    assert given == approx({site: OF_RETAINER[name](record, site) for site in given}, name)


@pytest.mark.parametrize("name", OF_TOUCHDOWN)
def test_a_value_of_the_touchdown(record, name):
    if record.given["touchdown"] is not None:
        assert record.given["touchdown"][name] == approx(OF_TOUCHDOWN[name](record), name)


def test_the_run_settles_for_the_cycles_of_its_scenario(record):
    asked = json.loads(record.attrs["scenario_data"])["settle_cycles"] * record.T
    if record.given["settling"] == "simulated":
        assert asked - 1e-12 <= record.given["settling_s"] < asked + record.h


def test_shares_of_methods_are_shares_of_steps(record):
    names = record.result.dataset["rotor_contact.solver.method"].attrs["flag_meanings"].split()
    counted = [names[int(value)] for value in record["solver.method"][record.t > 0.0]]
    assert record.given["steps_by_method"] == {
        n: counted.count(n) / len(counted) for n in sorted({*counted}, key=names.index)
    }


def test_events_are_where_the_unbalance_changes(record_of):
    for kind in ("levitation", "rub"):
        record = record_of(kind)
        u = next(values for name, values in record.signals.items() if name.endswith(".u") and np.ptp(values) > 0.0)
        cycles = record.cycle[np.flatnonzero(np.diff(u)) + 1]
        assert list(record.given["event_cycles_cycle"].values()) == pytest.approx(cycles, rel=1e-9)
