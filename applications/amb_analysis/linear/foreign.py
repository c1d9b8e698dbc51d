"""Linear model of an FMU with unknown equations, obtained from its derivatives or its responses to pulses.

An instance of the FMU runs several times from the same start. The first run is undisturbed. In each further run, one
input is raised by delta during one communication step. The resulting changes of the outputs, divided by delta, are the
samples of the impulse response,

    H_0 = D,  H_k = C A^(k-1) B,                                                                     (1)

from which the eigensystem realisation algorithm determines A, B, C: J.-N. Juang and R. S. Pappa, An eigensystem
realization algorithm, J. Guidance 8 (1985) 620-627. It does so for each group of inputs and outputs that the responses
connect. Pulses of the opposite sign reveal a nonlinear FMU. Pulses one step later reveal an FMU that does not sample in
every step, or a nonlinear FMU that moves without a pulse, as in a limit cycle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.sparse.csgraph import connected_components

from amb_analysis.linear.components import LinearComponent, names_of, zoh
from amb_cosim.controllers.laws import Law, side_by_side
from amb_cosim.cosim.errors import FmuError
from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from array_types import Array, Indices

STEPS = 240  # communication steps of a response
PROBE = 40  # communication steps of a response that shows whether a law is the same at another speed
RANK = 1e-9  # singular value of the responses' matrix, over the largest, that is no state
DERIVATIVES_ERROR = 0.01  # largest over the largest response: an FMU may have more states than it lists
UNCOUPLED = 1e-6  # response of an output to an input, over their largest ones, that is no path: as `ALIKE` for laws
NONLINEAR = 1e-6  # difference of pulses of both signs or in two steps, over the largest response, that a note reports
SLOWER = 0.01  # difference of pulses in two steps, over the largest response, from which there is no linear model
PULSES = {"m": 1e-6, "N": 1.0, "A": 1e-3, "V": 1e-3}  # height of an input's pulse, by its unit
PULSE = 1e-3  # in any other unit
GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # its multiples have different fractions


def foreign_component(
    name: str,
    folder: Path,
    interface: FmuInterface,
    start: Mapping[str, float],
    ends: tuple[Sequence[str], Sequence[str]],
    sample_time: float,
) -> LinearComponent:
    """Return the linear model of an FMU about its start values, with outputs at the end of each communication step.

    The model comes from the directional derivatives of the FMU, if the FMU provides them for all its states and they
    predict the responses to pulses. Otherwise the model is derived from these responses.

    Parameters
    ----------
    name, folder, interface
        Name, folder and interface of the component.
    start
        Values of parameters and inputs, by name.
    ends
        Names of its real inputs and outputs.
    sample_time
        Its communication step (s).

    Raises
    ------
    FmuError
        If the FMU fails to start or to step.
    ValueError
        If the outputs of the FMU are not finite, or depend on the step in which a pulse begins.
    """
    inputs, outputs = ends
    heights = [PULSES.get(interface.ports[i].unit or "", PULSE) for i in inputs]
    component = FmuComponent(name, folder, interface, inputs, outputs, start)
    try:
        rest = np.array([start.get(i, interface.ports[i].start or 0.0) for i in inputs])
        runs = _PulseRuns(component, (inputs, outputs, start), rest, sample_time)
        undisturbed = runs.response(np.zeros(len(inputs)))
        pulses = [h * e for h, e in zip(heights, np.eye(len(inputs)), strict=True)]
        pairs = [[runs.response(s * pulse) for s in (1.0, -1.0)] for pulse in pulses]
        delayed = [runs.response(pulse, 2) for pulse in pulses]
        runs.restart()
        derived = by_derivatives(component, interface.states, ends, sample_time) if interface.states else None
    finally:
        component.close()
    odd = np.array([(up - down) / (2.0 * h) for (up, down), h in zip(pairs, heights, strict=True)])
    even = np.array([(up + down - 2.0 * undisturbed) / (2.0 * h) for (up, down), h in zip(pairs, heights, strict=True)])
    if not np.isfinite(odd).all():
        raise ValueError(f"{name}: its outputs are not finite; it has no linear model")
    prompt = [up for up, _ in pairs]
    first, second = (
        np.array([(run - undisturbed) / h for run, h in zip(of_pulse, heights, strict=True)])
        for of_pulse in (prompt, delayed)
    )
    varying = _relative(second[:, 1:] - first[:, :-1], np.concatenate([first, second]))
    if varying > SLOWER:
        later = f"{name}: the response to a pulse changes if the pulse begins one step of {sample_time:g} s later"
        slower = (
            "which suggests that the component samples less often; the communication step must equal its sample time"
        )
        if np.any(undisturbed != undisturbed[0]):
            slower += (
                "; or the component moves without a pulse, as in a limit cycle, so it is nonlinear and has no linear "
                "model"
            )
        raise ValueError(f"{later}, {slower}")
    markov = np.moveaxis(odd, 0, 2)  # (step, output, input)
    law, note = _best(derived, markov, sample_time)
    curvature = _relative(even, markov)
    if curvature > NONLINEAR:
        note += f"; it is not linear: responses to positive and negative pulses differ by {curvature:.1g}"
    if varying > NONLINEAR:
        note += f"; it is not linear, or not at rest: responses to pulses in different steps differ by {varying:.1g}"
    return LinearComponent(
        law, names_of(name, inputs), names_of(name, outputs), notes=(f"{name}: {note}",), at_end=True
    )


def joint_response(
    name: str,
    folder: Path,
    interface: FmuInterface,
    start: Mapping[str, float],
    ends: tuple[Sequence[str], Sequence[str]],
    sample_time: float,
) -> Array:
    """Return the response of an FMU to pulses of all inputs in one step, shape (PROBE, n_outputs).

    If this response is the same from other start values (`responds_alike`), the linear model is the same. The pulses
    have different heights, so that effects of several inputs do not cancel. Arguments and errors are those of
    `foreign_component`.
    """
    inputs, outputs = ends
    heights = [PULSES.get(interface.ports[i].unit or "", PULSE) for i in inputs]
    pulse = np.array(heights) * (1.0 + (GOLDEN * np.arange(len(inputs))) % 1.0)
    component = FmuComponent(name, folder, interface, inputs, outputs, start)
    try:
        rest = np.array([start.get(i, interface.ports[i].start or 0.0) for i in inputs])
        runs = _PulseRuns(component, (inputs, outputs, start), rest, sample_time)
        return runs.response(pulse, steps=PROBE) - runs.response(np.zeros(len(inputs)), steps=PROBE)
    finally:
        component.close()


def responds_alike(response: Array, other: Array) -> bool:
    """Return whether two responses of `joint_response` differ in no output by more than `UNCOUPLED` of its largest."""
    return bool((np.abs(response - other).max(axis=0) <= UNCOUPLED * np.abs(other).max(axis=0)).all())


def _best(derived: Law | None, markov: Array, sample_time: float) -> tuple[Law, str]:
    """Return a law and a note on its accuracy.

    The law is computed from the derivatives if they predict the responses to pulses, and otherwise from the responses.
    """
    rejected = ""
    if derived is not None:
        error = _relative(responses(derived, len(markov)) - markov, markov)
        if error < DERIVATIVES_ERROR:
            return derived, (
                f"computed from its directional derivatives, with {len(derived.A)} states; the error of its responses "
                f"to pulses is {error:.1g} of the largest response"
            )
        rejected = f"; with its directional derivatives, the error is {error:.1g} of the largest response"
    law = realised(markov, sample_time)
    error = _relative(responses(law, len(markov)) - markov, markov)
    return (
        law,
        f"computed from its responses to pulses, with {len(law.A)} states and an error of {error:.1g} of the largest "
        f"response{rejected}",
    )


def by_derivatives(
    component: FmuComponent,
    states: Sequence[tuple[str, str]],
    ends: tuple[Sequence[str], Sequence[str]],
    sample_time: float,
) -> Law | None:
    """Return the law of an FMU from its directional derivatives; None if the FMU refuses them or they are not finite.

    For an FMU with x' = A x + B u and y = C x + D u, the states and outputs at the end of each step are

        x(n+1) = Phi x(n) + Gamma u(n),   y(n) = C Phi x(n) + (C Gamma + D) u(n)                     (2)

    In co-simulation, FMI 2.0 allows `fmi2GetDirectionalDerivative` if the model description lists the state
    derivatives. The function then differentiates state derivatives and outputs with respect to states and inputs.

    Parameters
    ----------
    component
        The component after its initialisation.
    states
        Name of each state and name of its derivative.
    ends
        Names of its real inputs and outputs.
    sample_time
        T (s), over which inputs are held.
    """
    inputs, outputs = ends
    x, rates = ([pair[k] for pair in states] for k in (0, 1))
    try:
        J = component.derivatives([*rates, *outputs], [*x, *inputs])
    except FmuError:
        return None
    n = len(x)
    if not np.isfinite(J).all():
        return None
    C, D = J[n:, :n], J[n:, n:]
    Phi, Gamma = zoh(J[:n, :n], J[:n, n:], sample_time)
    return Law(Phi, Gamma, C @ Phi, C @ Gamma + D, sample_time)


@dataclass(frozen=True, eq=False)
class _PulseRuns:
    """Runs of an FMU's instance, all from the same start.

    arguments
        Inputs, outputs and start values of the instance, as `FmuComponent.reset` takes them.
    rest
        Values of the undisturbed inputs, shape (n_inputs,).
    """

    component: FmuComponent
    arguments: tuple[Sequence[str], Sequence[str], Mapping[str, float]]
    rest: Array
    sample_time: float

    def restart(self) -> None:
        """Reset the instance to its start values."""
        self.component.reset(*self.arguments)
        self.component.inputs[:] = self.rest
        self.component.enter(0.0)
        self.component.write()
        self.component.leave()

    def response(self, pulse: Array, at: int = 1, steps: int = STEPS) -> Array:
        """Return the outputs after each step except the first, shape (steps, n_outputs), for a pulse in step `at`.

        There is no pulse in the first step: an FMU may start in equilibrium with its initial inputs, which would
        include the pulse.
        """
        component, result = self.component, []
        self.restart()
        for n in range(steps + 1):
            component.inputs[:] = self.rest + (pulse if n == at else 0.0)
            component.write()
            component.step(n * self.sample_time, self.sample_time)
            component.read()
            result.append(component.outputs.copy())
        return np.array(result[1:])


def realised(markov: Array, sample_time: float) -> Law:
    """Return the law of lowest order whose impulse response (1) is `markov`, shape (steps, n_outputs, n_inputs).

    Inputs and outputs without a path between them, such as those of controllers of different axes, have their own
    states. Their coupling is exactly 0, not that of rounding in a common realisation.
    """
    groups = _groups(markov)
    law = side_by_side([_realised(markov[:, outputs[:, None], inputs], sample_time) for outputs, inputs in groups])
    rows, columns = (np.argsort(np.concatenate([group[k] for group in groups])) for k in (0, 1))
    return Law(law.A, law.B[:, columns], law.C[rows], law.D[np.ix_(rows, columns)], sample_time)


def _groups(markov: Array) -> list[tuple[Indices, Indices]]:
    """Return outputs and inputs that responses above `UNCOUPLED` connect, with each output and input in one group."""
    p, m = markov.shape[1:]
    size = np.abs(markov).max(axis=0)
    scale = np.sqrt(np.outer(size.max(axis=1), size.max(axis=0)))
    links = np.zeros((p + m, p + m), dtype=bool)
    links[:p, p:] = size > UNCOUPLED * scale
    count, label = connected_components(links, directed=False)
    return [(np.flatnonzero(label[:p] == k), np.flatnonzero(label[p:] == k)) for k in range(count)]


def _realised(markov: Array, sample_time: float) -> Law:
    """Return the law of lowest order for outputs and inputs that are connected; arguments as for `realised`."""
    steps, p, m = markov.shape
    if not (p and m):
        return Law(np.zeros((0, 0)), np.zeros((0, m)), np.zeros((p, 0)), np.zeros((p, m)), sample_time)
    half = (steps - 1) // 2
    sizes = [np.abs(markov).max(axis=axes) for axes in ((0, 2), (0, 1))]
    rows, columns = (np.where(size > 0.0, size, 1.0) for size in sizes)
    H = markov / rows[None, :, None]
    columns = np.where(np.abs(H).max(axis=(0, 1)) > 0.0, np.abs(H).max(axis=(0, 1)), columns)
    H = H / columns
    first, second = (np.block([[H[i + j + shift] for j in range(half)] for i in range(half)]) for shift in (1, 2))
    U, s, Vt = np.linalg.svd(first, full_matrices=False)
    n = int(np.sum(s > RANK * max(s[0], 1e-300))) if s[0] > RANK else 0
    root = np.sqrt(s[:n])
    A = (U[:, :n].T @ second @ Vt[:n].T) / np.outer(root, root)
    B, C = (root[:, None] * Vt[:n])[:, :m] * columns, rows[:, None] * (U[:, :n] * root)[:p]
    return Law(A, B, C, markov[0], sample_time)


def responses(law: Law, steps: int) -> Array:
    """Return the impulse response (1) of a law, shape (steps, n_outputs, n_inputs)."""
    result, state = [law.D], law.B
    for _ in range(steps - 1):
        result.append(law.C @ state)
        state = law.A @ state
    return np.array(result)


def _relative(error: Array, markov: Array) -> float:
    return float(np.abs(error).max() / max(np.abs(markov).max(), 1e-300))
