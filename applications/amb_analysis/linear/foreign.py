"""The linear model of an FMU with unknown equations, from its derivatives or its responses to pulses.

An instance runs from the same start once undisturbed, and once for each input with that input raised by delta during
a communication step. The differences of its outputs, over delta, are the samples of its impulse response,

    H_0 = D,  H_k = C A^(k-1) B,                                                                     (1)

of which the eigensystem realisation algorithm makes A, B, C: J.-N. Juang and R. S. Pappa, An eigensystem realization
algorithm, J. Guidance 8 (1985) 620-627. Pulses of the other sign reveal an FMU that is nonlinear or depends on time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from amb_analysis.linear.components import LinearComponent, names_of, zoh
from amb_cosim.controllers.laws import Law
from amb_cosim.cosim.basics.errors import FmuError
from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from array_types import Array

STEPS = 240  # communication steps of a response
RANK = 1e-9  # singular value of the responses' matrix, over the largest, that is no state
NOT_JUDGED = (
    0.01  # error, over the largest response, up to which derivatives count: an FMU may have more states than it lists
)
STATED = 1e-6  # error, over the largest response, from which a model is said to be in doubt
DELTAS = {"m": 1e-6, "N": 1.0, "A": 1e-3, "V": 1e-3}  # of an input, by its unit
DELTA = 1e-3


def foreign_component(
    name: str,
    folder: Path,
    interface: FmuInterface,
    start: Mapping[str, float],
    ends: tuple[Sequence[str], Sequence[str]],
    sample_time: float,
) -> LinearComponent:
    """Return the model of an FMU about its start values, at the end of each communication step.

    By the directional derivatives of an FMU that provides them for all its states, if these predict the responses to
    pulses; else by the pulses.

    Parameters
    ----------
    name, folder, interface
        Of the component.
    start
        Values of parameters and inputs, by name.
    ends
        Names of its real inputs and outputs.
    sample_time
        Its step (s).

    Raises
    ------
    FmuError
        If it refuses to start or to step.
    ValueError
        If its outputs are not finite.
    """
    inputs, outputs = ends
    deltas = [DELTAS.get(interface.ports[i].unit or "", DELTA) for i in inputs]
    component = FmuComponent(name, folder, interface, inputs, outputs, start)
    try:
        rest = np.array([start.get(i, interface.ports[i].start or 0.0) for i in inputs])
        answer = _Answers(component, (inputs, outputs, start), rest, sample_time)
        still = answer.to(np.zeros(len(inputs)))
        pulses = [[answer.to(s * d * e) for s in (1.0, -1.0)] for d, e in zip(deltas, np.eye(len(inputs)), strict=True)]
        answer.begin()
        derived = by_derivatives(component, interface.states, ends, sample_time) if interface.states else None
    finally:
        component.close()
    each = np.array([(up - down) / (2.0 * d) for (up, down), d in zip(pulses, deltas, strict=True)])
    bent = np.array([(up + down - 2.0 * still) / (2.0 * d) for (up, down), d in zip(pulses, deltas, strict=True)])
    if not np.isfinite(each).all():
        raise ValueError(f"{name}: its outputs are not finite; it has no linear model")
    markov = np.moveaxis(each, 0, 2)  # (step, output, input)
    law, stated = _best(derived, markov, sample_time)
    curvature = _relative(bent, markov)
    if curvature > STATED:
        stated += f"; it is not linear, pulses of both signs differ by {curvature:.1g}"
    return LinearComponent(
        law, names_of(name, inputs), names_of(name, outputs), notes=(f"{name}: {stated}",), at_end=True
    )


def _best(derived: Law | None, markov: Array, sample_time: float) -> tuple[Law, str]:
    """Return the law from derivatives if it predicts the pulses, otherwise the law from the pulses, and a note."""
    missed = ""
    if derived is not None:
        error = _relative(responses(derived, len(markov)) - markov, markov)
        if error < NOT_JUDGED:
            return derived, (
                f"by its directional derivatives, of {len(derived.A)} states; its largest response to pulses is missed "
                f"by {error:.1g} of itself"
            )
        missed = f"; by its directional derivatives its largest response is missed by {error:.1g} of itself"
    law = realised(markov, sample_time)
    error = _relative(responses(law, len(markov)) - markov, markov)
    return law, f"by differences, of {len(law.A)} states, with an error of {error:.1g} of its largest response{missed}"


def by_derivatives(
    component: FmuComponent,
    states: Sequence[tuple[str, str]],
    ends: tuple[Sequence[str], Sequence[str]],
    sample_time: float,
) -> Law | None:
    """Return the law of an FMU, x' = A x + B u, y = C x + D u, at the end of each step; None where it refuses.

        x(n+1) = Phi x(n) + Gamma u(n),   y(n) = C Phi x(n) + (C Gamma + D) u(n)                     (2)

    FMI 2.0 has `fmi2GetDirectionalDerivative` of state derivatives and outputs by states and inputs for a model in
    co-simulation too, where the description lists its state derivatives.

    Parameters
    ----------
    component
        After its initialisation.
    states
        Names of its states and of their derivatives.
    ends
        Names of its real inputs and outputs.
    sample_time
        T (s), through which inputs are held.
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
class _Answers:
    """Runs of an instance from its start, with its inputs, its outputs and its start values."""

    component: FmuComponent
    arguments: tuple[Sequence[str], Sequence[str], Mapping[str, float]]
    rest: Array
    sample_time: float

    def begin(self) -> None:
        """Reset the instance to its start."""
        self.component.reset(*self.arguments)
        self.component.inputs[:] = self.rest
        self.component.enter(0.0)
        self.component.write()
        self.component.leave()

    def to(self, pulse: Array) -> Array:
        """Return the outputs after each step but the first, shape (STEPS, n_outputs), with a pulse during the second.

        The first step has none, because an FMU may start at rest under its initial inputs.
        """
        component, result = self.component, []
        self.begin()
        for n in range(STEPS + 1):
            component.inputs[:] = self.rest + (pulse if n == 1 else 0.0)
            component.write()
            component.step(n * self.sample_time, self.sample_time)
            component.read()
            result.append(component.outputs.copy())
        return np.array(result[1:])


def realised(markov: Array, sample_time: float) -> Law:
    """Return the law of lowest order whose impulse response is `markov`, shape (steps, n_outputs, n_inputs) (1)."""
    steps, p, m = markov.shape
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
