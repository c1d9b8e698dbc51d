"""Largest forces of magnets, against the force law of the actuator."""

import json

import numpy as np
import pytest
import xarray as xr

from amb_actuator.force import pull, static_pull
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from amb_cosim.results import plots
from amb_cosim.results.magnet_limits import current_limits, force_limits
from tests.support.messages import raises_naming


def with_magnets(run: xr.Dataset, force: float, total: bool = True) -> xr.Dataset:
    """Add the force and the current of an axis in x, of constant size, to a run."""
    p = axis_parameters("mb1", "x")
    actuator = {f"mb1.{name}_x": float(p[name]) for name in p.dtype.names} | {"total_force": float(total)}
    controller = {"mb1.i_min_x": -5.57, "mb1.i_max_x": 4.43}
    parameters = json.loads(run.attrs["parameters"]) | {"amb_actuator": actuator, "rolac_controller": controller}
    constant = np.full(run.sizes["time"], force)
    added = {"amb_actuator.mb1.f_x": ("time", constant), "rolac_controller.mb1.i_x": ("time", 1e-3 * constant)}
    return run.assign(added).assign_attrs(parameters=json.dumps(parameters))


@pytest.mark.parametrize("total", [True, False])
def test_largest_force_is_that_of_a_saturated_coil_pair(synthetic, total):
    """Saturated iron limits the force below that of the largest current; excess force is lower by the static load."""
    p = axis_parameters("mb1", "x")
    low, high = force_limits(with_magnets(synthetic(), 100.0, total), "mb1.x")
    largest, static = pull(p, 100.0, p.gap).force, 0.0 if total else static_pull(p)
    assert (low, high) == pytest.approx((-largest - static, largest - static), rel=1e-9)


def test_a_system_without_magnets_has_no_force_limits(synthetic):
    assert force_limits(synthetic(), "mb1.x") is None
    assert current_limits(synthetic(), "mb1.x") is None
    with raises_naming(ValueError, "magnets", "neither a current nor a force"):
        plots.Plots(synthetic()).magnets()
