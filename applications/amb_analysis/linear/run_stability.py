"""Whether the loop of a run is stable, from the linear models of its components."""

from __future__ import annotations

import numpy as np

from amb_analysis.linear.linear_source import LinearSource, source_of_run
from amb_analysis.linear.loop import Loop
from amb_cosim.cosim.processes.blas import one_blas_thread
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.plan import ScenarioPlan

_kept: list[LinearSource] = []  # of the last assembly: the runs of a sweep share the constants of its models


@one_blas_thread()
def stability_of_run(plan: ScenarioPlan, Omega: float) -> LoopStability | None:
    """Return the stability of a run's loop at a spin speed (rad/s); None if the loop has no linear model."""
    try:
        return Loop(_source(plan)).poles(Omega).stability
    except (ValueError, np.linalg.LinAlgError):  # no magnets, several sample times, a loop without delay
        return None


def _source(plan: ScenarioPlan) -> LinearSource:
    if _kept and _kept[0].plan.assembly is plan.assembly:
        return _kept[0].with_plan(plan)
    _kept[:] = [source_of_run(plan)]
    return _kept[0]
