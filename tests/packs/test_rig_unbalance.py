"""The unbalance of the rig in chapter 6, fitted to the amplitudes that the thesis states under PID (mm)."""

import numpy as np
import pytest
from scipy.optimize import least_squares

import amb_cosim
from amb_cosim.cosim.system.values import quantity
from amb_cosim.scenario.scenario import load_scenario

UNIT = 2e-3  # kg m
WITHIN = {("fig6_6", 5): 0.1, ("fig6_6", 7): 0.2}  # the axes of Fig. 6.6, by scenario and sensor in x
READ = {("fig6_8", 7): 0.35, ("fig6_8", 5): 0.20, ("fig6_10", 3): 0.346, ("fig6_10", 5): 0.374}
MARGIN = 0.95  # of an axis: a curve ends within


def response_to(disc: str, name: str) -> np.ndarray:
    """Return the amplitudes at the eight sensors per unbalance of a disc under PID (mm/(kg m)), complex."""
    others = {f"d{k}.u": 0.0 for k in range(1, 5)} | {"d3.phi": 0.0}
    inputs = {
        "rotor_contact": others | {f"{disc}.u": UNIT},
        "rolac_controller": {"identify": False, "rolac_enable": False},
    }
    scenario = load_scenario(name).changed(settle_cycles=120, end_cycle=4, event=[], inputs=inputs)
    data = amb_cosim.run(scenario, set={"rolac_controller.chain.noise": 0}, progress=False).dataset
    size, phase = (
        np.array([float(data[f"rolac_controller.{part}.s{k}"].values[-1]) for k in range(1, 9)])
        for part in ("amplitude", "phase")
    )
    return 1e3 * size * np.exp(1j * phase) / UNIT


def test_unbalance_of_the_rig_is_that_of_least_squares():
    """Errors are logarithms; amplitudes within an axis have none. The rounded values are within 2 % of the optimum."""
    names = dict.fromkeys(name for name, _ in (*WITHIN, *READ))
    response = {(name, disc): response_to(disc, name) for name in names for disc in ("d1", "d3")}

    def errors(p):
        first, second = p[0], p[1] * np.exp(1j * p[2])
        amplitudes = {
            (name, s): np.linalg.norm((first * response[name, "d1"] + second * response[name, "d3"])[s - 1 : s + 1])
            for name, s in (*WITHIN, *READ)
        }
        within = [max(np.log(amplitudes[key] / np.sqrt(2.0) / (MARGIN * axis)), 0.0) for key, axis in WITHIN.items()]
        return np.array([*within, *(np.log(amplitudes[key] / np.sqrt(2.0) / stated) for key, stated in READ.items())])

    inputs = load_scenario("fig6_6").inputs["rotor_contact"]
    units = {"d1.u": "kg.m", "d3.u": "kg.m", "d3.phi": "rad"}
    stated = np.array([quantity(inputs[name], unit, name) for name, unit in units.items()])
    found = least_squares(errors, stated, x_scale=np.abs(stated))
    rms = lambda p: np.sqrt(np.mean(errors(p) ** 2))  # noqa: E731
    assert rms(found.x) == pytest.approx(0.043, abs=0.002)
    assert rms(stated) < 1.02 * rms(found.x)
    assert np.abs(errors(stated)).max() == pytest.approx(0.075, abs=0.005)
