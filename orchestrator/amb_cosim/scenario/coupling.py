"""Which communication step a coupling needs, and how far a controller has to look ahead in it.

In Gauss-Seidel order the controller's currents act from the instant of its sample on. In Jacobi order everything passes
on at the end of a step: the currents leave the controller a step after the displacements that they answer, and the
force leaves the actuator another step later. With the step h the loop is 2 h slower than the controller alone. A delay
tau takes omega tau of the loop's phase margin, and so of its damping. A controller that predicts its displacements by
2 h makes up for it, to first order in h: what remains grows with (omega h)^2. See `docs/coupling.md`.
"""

from __future__ import annotations

from collections.abc import Mapping

from amb_cosim.cosim.basics.choices import Coupling
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface

DEFAULT_STEPS: Mapping[Coupling, float] = {"gauss_seidel": 250e-6, "jacobi": 25e-6, "iterative": 250e-6}  # s
LARGEST_SHARE = 0.2  # of the controller's sample time, for a step in Jacobi order; see `longest_jacobi_step`
USUAL_SAMPLE_TIME = 250e-6  # s; of a controller that does not say its own
PREDICTION = "prediction_time"  # parameter of a component that can look ahead
SAMPLE_TIME = "sample_time"  # parameter of a component that samples


def delay(coupling: Coupling, step_size: float) -> float:
    """Return by how much a force is late after the displacement that it answers (s), for a communication step (s)."""
    return 2.0 * step_size if coupling == "jacobi" else 0.0


def predictable(interfaces: Mapping[str, FmuInterface]) -> list[str]:
    """Return the parameters, `component.variable`, that say how far a component looks ahead."""
    result = {component: interface.ports.get(PREDICTION) for component, interface in interfaces.items()}
    return [f"{component}.{PREDICTION}" for component, port in result.items() if port and port.causality == "parameter"]


def longest_jacobi_step(sample_time: float) -> float:
    """Return the longest communication step (s) in Jacobi order for a controller of a sample time (s): a fifth of it.

    How fast a controller samples tells how fast its loop is, so that this bounds the phase that the delay takes. A loop
    sampled at 4 kHz is then within 5 % of Gauss-Seidel order in the orbit of a rub, without prediction; one of little
    margin at 10 kHz needs prediction with it. `docs/coupling.md` has both.
    """
    return LARGEST_SHARE * sample_time


def coupling_warning(
    coupling: Coupling, step_size: float, prediction_time: float = 0.0, sample_time: float | None = None
) -> str | None:
    """Return a sentence that says why the results of a levitated rotor are in doubt, or None.

    Parameters
    ----------
    coupling, step_size
        Of the master; communication step (s).
    prediction_time
        How far the controller looks ahead (s).
    sample_time
        Of the controller (s); None where it does not say.
    """
    longest = longest_jacobi_step(sample_time or USUAL_SAMPLE_TIME)
    if coupling != "jacobi" or step_size <= longest * (1.0 + 1e-9):
        return None
    step, late, ahead, most = (1e6 * time for time in (step_size, delay(coupling, step_size), prediction_time, longest))
    foreseen = f", of which the controller predicts {ahead:g} us" if prediction_time > 0.0 else ""
    whose = "of the controller's sample time" if sample_time else f"of {1e6 * USUAL_SAMPLE_TIME:g} us between samples"
    return (
        f"with communication_step = {step:g} us in Jacobi order each force comes {late:g} us after the displacements "
        f"that it answers{foreseen}; that changes the damping of a levitated rotor, or makes it unstable. "
        f"Keep to steps of at most {most:g} us, a fifth {whose}"
    )
