"""Step sizes in whole nanoseconds, as in libcosim."""

from typing import Any


def step_between_nanoseconds() -> None:
    """Have this project's master pass the times of libcosim to FMUs, in this process from now on.

    A point is a whole number of nanoseconds, and a step the difference of two points, which deviates from a constant
    in the last bits.
    """
    from amb_cosim.cosim.fmu.component import FmuComponent

    step = FmuComponent.step

    def step_between_points(component: Any, time: float, step_size: float) -> None:
        begin, end = (round(t * 1e9) / 1e9 for t in (time, time + step_size))
        step(component, begin, end - begin)

    FmuComponent.step = step_between_points
