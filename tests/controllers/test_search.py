"""The search for a controller sees the poles that the sampled loop has, and asks for the damping that it says."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from scipy.signal import bilinear

import amb_cosim

pytestmark = pytest.mark.slow

MACHINE, STEP = "compressor_levitated", 1e-4
LAWS = [(2.34e4, 36.0, 1500.0, 900.0, 0.5, 1.5), (2.5e4, 30.0, 1200.0, 700.0, 0.3, 0.8)]


@pytest.fixture(scope="module")
def room(examples):
    import search

    return search


@pytest.fixture(scope="module")
def machine(room):
    return room.Search(MACHINE, ["9000 rpm"], {"mb1": "mb1", "mb2": "mb2"}, STEP, 1e-6, 1.0)


def test_poles_of_the_search_are_those_of_the_loop_with_its_file(room, machine, tmp_path):
    file = tmp_path / "law.toml"
    file.write_text(machine.text(LAWS), encoding="utf-8")
    loop = amb_cosim.linearise(MACHINE, "9000 rpm", fmu={"rolac_controller": file})
    z = loop.poles()
    expected = np.log(z[np.abs(z) > 1e-6]) / STEP
    ratios = [bilinear(*room._ratio(*of), 1.0 / STEP) for of in LAWS]
    result = room._poles(machine.plants[0], room._law(ratios), STEP)
    slow = [np.sort_complex(s[(s.imag > 1.0) & (s.imag < 8e3)]) for s in (result, expected)]
    assert len(slow[0]) > 8
    np.testing.assert_allclose(slow[0], slow[1], rtol=1e-6)


def test_noise_of_a_demand_is_that_of_a_first_order_filter(room):
    """b/(1 - a/z) under white noise has the variance b^2/(1 - a^2)."""
    assert room._of_noise([0.5, 0.0], [1.0, -0.8]) == pytest.approx(0.5 / np.sqrt(1.0 - 0.8**2), rel=1e-9)


def test_a_vibration_near_the_speeds_costs_what_it_lacks_of_damping(machine):
    def cost(omega, decrement):
        return machine._of_decrements(np.array([omega * (1j - decrement / (2.0 * np.pi))]))

    assert cost(942.0, 0.1) == pytest.approx(4.0 * 1.5 + 10.0 * 0.1)
    assert cost(300.0, 0.1) == pytest.approx(10.0 * 0.1)
    assert cost(5000.0, 0.04) == 0.0
    assert cost(5000.0, -0.01) == pytest.approx(60.0 * 0.04)


@pytest.mark.parametrize("is_late", [False, True])
def test_file_of_the_search_has_one_delay_and_the_limits_of_the_scenario(room, tmp_path, is_late):
    """A demand comes a sample late in all: by the chain of the scenario if that has a delay, or by the file."""
    scenario = tmp_path / "late.toml"
    chain = f'"chain.preset" = "custom"\n"chain.delay" = {str(is_late).lower()}'
    limits = '"mb1.i_max_?" = "3 A"\n"mb2.i_max_?" = "4 A"\n"*.i_min_?" = "-3.5 A"'
    text = f'base = "{MACHINE}"\n[parameters.rolac_controller]\n{chain}\n{limits}\n'
    scenario.write_text(text, encoding="utf-8")
    search = room.Search(str(scenario), ["9000 rpm"], {"mb1": "mb1", "mb2": "mb2"}, STEP)
    data = tomllib.loads(search.text(LAWS))
    assert data.get("delay", 0) + is_late == 1
    assert data["limits"] == ["-3.5 A", "3 A"]


def test_search_reports_its_best_after_each_generation(machine, capsys):
    machine.best(2)
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("generation")]
    assert [line.split(":")[0] for line in lines] == ["generation 1", "generation 2"]
    costs = [float(line.split(":")[1]) for line in lines]
    assert costs[1] <= costs[0]
