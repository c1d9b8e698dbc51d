"""Communication step and prediction time that a coupling requires.

In Gauss-Seidel order the controller's currents act from the instant of its sample. In Jacobi order all values are
exchanged at the end of a step, so the currents leave the controller one step after the displacements, and the force
leaves the actuator another step later. With step h this adds a delay of 2 h to the loop. A delay tau reduces the loop's
phase margin by omega tau, and thus reduces its damping. A controller that predicts displacements 2 h ahead compensates
for this delay to first order in h; the remainder grows with (omega h)^2. See `docs/coupling.md`.
"""

from __future__ import annotations

from collections.abc import Mapping

from amb_cosim.cosim.choices import Coupling
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface

DEFAULT_STEPS: Mapping[Coupling, float] = {"gauss_seidel": 250e-6, "jacobi": 25e-6, "iterative": 250e-6}  # s
LARGEST_SHARE = 0.2  # of the controller's sample time, for a step in Jacobi order; see `coupling_warning`
USUAL_SAMPLE_TIME = 250e-6  # s; assumed for a controller that states none
PREDICTION = "prediction_time"  # parameter of a component that can look ahead
SAMPLE_TIME = "sample_time"  # parameter of a component that samples


def delay(coupling: Coupling, step_size: float) -> float:
    """Return the delay from displacement to force (s) for a communication step (s)."""
    return 2.0 * step_size if coupling == "jacobi" else 0.0


def predictable(interfaces: Mapping[str, FmuInterface]) -> list[str]:
    """Return the names, `component.variable`, of the parameters that set the prediction times of components."""
    ports = {component: interface.ports.get(PREDICTION) for component, interface in interfaces.items()}
    return [f"{component}.{PREDICTION}" for component, port in ports.items() if port and port.causality == "parameter"]


def coupling_warning(
    coupling: Coupling, step_size: float, prediction_time: float = 0.0, sample_time: float | None = None
) -> str | None:
    """Return a warning if the coupling makes the results of a levitated rotor doubtful; otherwise None.

    In Jacobi order, a step of up to a fifth of the sample time is accepted. The sample time indicates the bandwidth of
    the loop, so this limit bounds the phase lag of the delay. With such a step and no prediction, a rubbing rotor in a
    loop sampled at 4 kHz has an orbit within 5 % of its orbit in Gauss-Seidel order. A loop with little margin that is
    sampled at 10 kHz requires prediction and a step of a tenth of the sample time. `docs/coupling.md` describes both.

    Parameters
    ----------
    coupling, step_size
        Order in which the master exchanges values, and communication step (s).
    prediction_time
        Prediction time of the controller (s).
    sample_time
        Sample time of the controller (s); None if unknown.
    """
    longest = LARGEST_SHARE * (sample_time or USUAL_SAMPLE_TIME)
    if coupling != "jacobi" or step_size <= longest * (1.0 + 1e-9):
        return None
    step, lag, ahead, most = (1e6 * time for time in (step_size, delay(coupling, step_size), prediction_time, longest))
    compensation = f" (the controller predicts {ahead:g} µs of this delay)" if prediction_time > 0.0 else ""
    whose = "of the controller's sample time" if sample_time else f"of {1e6 * USUAL_SAMPLE_TIME:g} µs between samples"
    return (
        f"with communication_step = {step:g} µs in Jacobi order, each force comes {lag:g} µs after the displacements "
        f"that it responds to{compensation}; this changes the damping of a levitated rotor and may make it unstable. "
        f"Use steps of at most {most:g} µs, a fifth {whose}"
    )
