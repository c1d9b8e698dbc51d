"""The stability of a run's loop, from its linear model, which an application computes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.plan import ScenarioPlan
from amb_files.packs import entry_points_of

GROUP = "amb_cosim.loop_stability"  # entry point of the function with the arguments of `loop_at_the_end`

Analysis = Callable[[ScenarioPlan, float, float], LoopStability | None]


def loop_at_the_end(plan: ScenarioPlan, end: float, Omega: float) -> LoopStability | None:
    """Return the stability of the loop with the inputs that a run has at its end; None if it is not known.

    The linear model is that of the applications, which import this package, so that it is found by its entry point.

    Parameters
    ----------
    plan
        Plan of the run.
    end, Omega
        Time (s) and spin speed (rad/s) at the end of the run.
    """
    analysis = _analysis()
    return None if analysis is None else analysis(plan, end, Omega)


@cache
def _analysis() -> Analysis | None:
    found = entry_points_of(GROUP)
    return found[0].load() if found else None
