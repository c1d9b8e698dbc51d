"""OLAC: one update to the optimum, only when steady, as often as allowed."""

import numpy as np
import pytest
from controller_bench import SAMPLES
from rig import pack

from amb_cosim.model_constants.controller_data import inverse_receptance
from rolac_controller.enumerations import OLAC


@pytest.fixture
def run_up_to(responding):
    """Makes OLAC on the plant q = Re[(Q_0 + R U) exp(j theta)] and the function that runs it by revolutions."""

    def make(table_of=None, **parameters):
        b, run = responding(table_of, rolac__mode=OLAC, **parameters)
        return b, lambda revolutions, *unbalance: run(revolutions * SAMPLES, *unbalance)

    return make


def test_one_update_reaches_the_optimum_of_a_linear_plant(run_up_to, optimum):
    _, run = run_up_to()
    assert not run(2).any()
    np.testing.assert_allclose(run(2), optimum, rtol=1e-10)
    np.testing.assert_allclose(run(20), optimum, rtol=1e-9)


def test_update_follows_a_later_change_of_unbalance(run_up_to, optimum):
    _, run = run_up_to()
    run(6)
    np.testing.assert_allclose(run(10, lambda n: 2.5), 2.5 * optimum, rtol=1e-9)


def test_number_of_updates_is_limited_until_olac_is_switched_on_again(run_up_to, optimum):
    b, run = run_up_to(olac__updates=1)
    run(6)
    np.testing.assert_allclose(run(10, lambda n: 2.5), optimum, rtol=1e-9)
    b["rolac_enable"] = 0.0
    run(1)
    b["rolac_enable"] = 1.0
    np.testing.assert_allclose(run(10, lambda n: 2.5), 2.5 * optimum, rtol=1e-9)


def test_no_update_is_made_while_the_vibration_grows(run_up_to):
    """By more than 2 % from one revolution to the next."""
    _, run = run_up_to()
    assert not run(30, lambda n: 1.05**n).any()
    _, run = run_up_to()
    assert run(30, lambda n: 1.005**n).any()


def test_vibration_that_does_not_respond_is_updated_every_two_revolutions(
    bench, receptance, speed_of, unbalance_response
):
    """Both revolutions that are compared lie after the last update."""
    values = {"rolac__mode": OLAC, "rolac__force_limit": 1e9, "rolac_enable": 1.0}
    b = bench(pack([1.0], [receptance]), Omega=speed_of(SAMPLES), **values)
    b.follow(lambda theta: (unbalance_response * np.exp(1j * theta)).real, 21 * SAMPLES + 5)
    np.testing.assert_allclose(b.forces(), 10 * inverse_receptance(receptance) @ unbalance_response, rtol=1e-9)


def test_olac_converges_if_the_error_of_h_is_below_one(run_up_to, receptance, optimum):
    """U <- U + H Q contracts by 1 - 1/1.4 for R taken 1.4 times too large; each update waits for steady vibration."""
    _, run = run_up_to(1.4 * receptance)
    np.testing.assert_allclose(run(60), optimum, rtol=1e-3)


def test_force_limit_applies_to_olac(run_up_to, optimum):
    limit = 0.5 * np.abs(optimum).max()
    b, run = run_up_to(rolac__force_limit=limit)
    assert np.abs(run(8)).max() == pytest.approx(limit, rel=1e-12)
    assert b["rolac_limited"] == 1.0
