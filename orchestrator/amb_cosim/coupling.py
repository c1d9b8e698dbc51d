"""Which communication step a coupling needs.

In Gauss-Seidel order the controller's currents act from the instant of its sample on. In Jacobi order everything passes
on at the end of a step: the currents leave the controller a step after the displacements that they answer, and the
force leaves the actuator another step later. With the step h the loop is 2 h slower than the controller alone, less
what the controller predicts. A delay tau takes omega tau of the loop's phase margin, and so of its damping:
`study coupling` shows what that does to orbits.
"""

from __future__ import annotations

from collections.abc import Mapping

from amb_cosim.cosim.choices import Coupling

DELAY_STEPS = 2  # of the force after the displacement that it answers, in Jacobi order
DEFAULT_STEPS: Mapping[Coupling, float] = {"gauss_seidel": 250e-6, "jacobi": 25e-6, "iterative": 250e-6}  # s
LONGEST_DELAY = 100e-6  # s; the orbit of fig4_9 is then within 5 % of that in Gauss-Seidel order


def doubt(coupling: Coupling, step_size: float, prediction_time: float = 0.0) -> str | None:
    """Return a sentence that says why the results of a levitated rotor are in doubt, or None.

    Parameters
    ----------
    coupling, step_size
        Of the master; communication step (s).
    prediction_time
        How far the controller looks ahead (s).
    """
    delay = DELAY_STEPS * step_size - prediction_time
    if coupling != "jacobi" or abs(delay) <= LONGEST_DELAY * (1.0 + 1e-9):
        return None
    step, late, longest = (1e6 * abs(time) for time in (step_size, delay, LONGEST_DELAY))
    side = "before" if delay > 0.0 else "after"
    return (
        f"with communication_step = {step:g} us in Jacobi order each force answers the displacements of {late:g} us "
        f"{side} it, which changes the damping of a levitated rotor or makes it unstable; up to {longest:g} us the "
        "orbits of the rig are within 5 % of those in Gauss-Seidel order. Steps of up to "
        f"{longest / DELAY_STEPS:g} us, or rolac_controller.prediction_time = {DELAY_STEPS * step:g} us, help"
    )
