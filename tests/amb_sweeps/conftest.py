"""A cluster that tests share, and a small sweep."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from amb_cosim.scenario.scenario import Scenario, load_scenario
from amb_sweeps.refine import Refinement
from amb_sweeps.run import Sweep
from amb_sweeps.sampling import sample_plan
from amb_sweeps.store import SweepStore
from amb_sweeps.worker import PointResult
from tests.orchestrator.conftest import runner

__all__ = ("runner",)

VARY = {"Omega": "200:260 rad/s:3", "rotor_contact.d1.u": "5 g.m:60 g.m:3"}
UNTIL = 0.06


@pytest.fixture(scope="session")
def small() -> Scenario:
    """Fig. 4.9 without the most of its settling."""
    return load_scenario("fig4_9").changed(settle_cycles=2)


@pytest.fixture(scope="session")
def cluster(cache: Path) -> Any:
    """Address of a local cluster with two processes, which needs no certificate."""
    import dask

    from amb_sweeps.engine import SETTINGS, local_cluster

    with dask.config.set(SETTINGS), local_cluster(2, security=None) as running:
        yield running.scheduler_address


def filled(
    folder: Path, vary: dict[str, Any], function: Callable[[dict[str, Any]], dict[str, float]], sample: str = "grid"
) -> Sweep:
    """Return a sweep whose metrics are a function of its coordinates."""
    design = sample_plan(vary, sample)
    store = SweepStore(folder, design, {"scenario": {"name": "made up"}}, {})
    store.add([PointResult(n, "recovered", "", function(design.settings(n))) for n in range(design.size)])
    return Sweep(folder, design)


def refined(swept: Sweep, tolerance: float, recovers: Callable[[dict[str, Any]], bool]) -> tuple[Refinement, int]:
    """Refine the boundary of `recovered` of a sweep, and count the runs."""
    refinement, runs = Refinement(swept.design, swept.dataset, tolerance, "recovered"), 0
    while (points := refinement.next_round()) is not None:
        runs += points.size
        values = [float(recovers(points.settings(n))) for n in range(points.size)]
        refinement.learn(xr.Dataset({"recovered": ("point", values)}))
    return refinement, runs


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    """Check that two sweeps have the same to the last bit, except for the time that they took."""
    assert set(one.variables) == set(other.variables)
    for name in set(one.variables) - {"seconds"}:
        np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))
