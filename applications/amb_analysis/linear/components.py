"""Linear parts with named signals, and their connection and sampling.

    x' = A x + B w     or     x(n+1) = A x(n) + B w(n),     y = C x + D w

Signals are called `component.variable`. An input w is the sum of the output that feeds it and an injected signal u:

    w = E y + u     =>     w = (1 - E D)^-1 (E C x + u)                                             (1)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, matrix_balance

from amb_cosim.controllers.laws import Law, side_by_side
from array_types import Array, Complex

WELL_POSED = 1e-12  # smallest singular value of the balanced 1 - E D, over the largest


@dataclass(frozen=True, eq=False)
class LinearComponent:
    """A linear component.

    law
        Matrices of the component, and its sample time (s), which is None if the component is continuous.
    inputs, outputs
        Names of the inputs in the order of the columns, and of the outputs in the order of the rows.
    late
        Delay of the outputs of a sampled part as a fraction of a sample, from 0 to 1.
    notes
        Sentences about effects that the model neglects, or about its accuracy.
    at_end
        Whether the outputs of a sampled part appear only at the end of a step.
    """

    law: Law
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    late: float = 0.0
    notes: tuple[str, ...] = ()
    at_end: bool = False

    def selected(self, inputs: Sequence[str], outputs: Sequence[str]) -> LinearComponent:
        """Return the part with only these inputs and outputs, in this order."""
        columns = [self.inputs.index(name) for name in inputs]
        rows = [self.outputs.index(name) for name in outputs]
        law = self.law
        chosen = Law(law.A, law.B[:, columns], law.C[rows], law.D[np.ix_(rows, columns)], law.sample_time)
        return LinearComponent(chosen, tuple(inputs), tuple(outputs), self.late, self.notes)


class StateSpace(Protocol):
    """Matrices of x' = A x + B w or x(n+1) = A x(n) + B w(n), y = C x + D w, real or complex."""

    @property
    def A(self) -> NDArray[Any]: ...
    @property
    def B(self) -> NDArray[Any]: ...
    @property
    def C(self) -> NDArray[Any]: ...
    @property
    def D(self) -> NDArray[Any]: ...


def without_idle_states(law: Law) -> Law:
    """Remove the states that no input affects and the states that affect no output, using the zeros of the matrices.

    If only some inputs and outputs of a law were selected, this removes the states of unrelated loops without
    approximation.
    """
    A, moved, seen = law.A != 0.0, np.any(law.B != 0.0, axis=1), np.any(law.C != 0.0, axis=0)
    for _ in range(len(A)):
        moved, seen = moved | (A @ moved), seen | (seen @ A)
    used = np.flatnonzero(moved & seen)
    return Law(law.A[np.ix_(used, used)], law.B[used], law.C[:, used], law.D, law.sample_time)


def frequency_response(law: StateSpace, s: complex | Complex) -> Complex:
    """Return C (s - A)^-1 B + D at a point s, or at points along the first axis; for a sampled law, z replaces s."""
    points = np.asarray(s)[..., np.newaxis, np.newaxis]
    return np.asarray(law.C @ np.linalg.solve(points * np.eye(len(law.A)) - law.A, law.B) + law.D, np.complex128)


def harmonic_response(law: StateSpace, omega: float | Array | Complex, sample_time: float | None) -> Complex:
    """Return the `frequency_response` at omega (rad/s): s = j omega, or z = exp(j omega T) with a sample time T (s).

    For frequencies of shape (n,), the result has the shape (n, outputs, inputs).
    """
    s = 1j * np.asarray(omega, np.complex128)
    return frequency_response(law, s if sample_time is None else np.exp(s * sample_time))


def names_of(component: str, variables: Sequence[str]) -> tuple[str, ...]:
    """Return the names `component.variable` of a component's variables."""
    return tuple(f"{component}.{variable}" for variable in variables)


def connected(parts: Sequence[LinearComponent], feeds: Mapping[str, str]) -> LinearComponent:
    """Connect parts by (1), and return the result as one part.

    The outputs of the connected parts come first. The sums w at the inputs follow; inputs with the same name as an
    output are left out.

    Parameters
    ----------
    parts
        Parts that are all continuous, or all sampled with the same sample time.
    feeds
        The output that feeds each input, by the name of the input.

    Raises
    ------
    ValueError
        If the connections form a loop without delay that has no solution.
    """
    parts_law = side_by_side([part.law for part in parts])
    inputs = tuple(name for part in parts for name in part.inputs)
    outputs = tuple(name for part in parts for name in part.outputs)
    row, column = ({name: k for k, name in enumerate(names)} for names in (outputs, inputs))
    E = np.zeros((len(inputs), len(outputs)))
    for target, source in feeds.items():
        E[column[target], row[source]] = 1.0
    direct = np.eye(len(inputs)) - E @ parts_law.D
    if not _is_solvable(direct):
        raise ValueError(
            "the connections form a loop without delay, and its equations have no unique solution; the system has no "
            "linear model"
        )
    W = np.linalg.inv(direct)
    summed = W @ E @ parts_law.C
    inputs_only = [k for k, name in enumerate(inputs) if name not in row]
    law = Law(
        parts_law.A + parts_law.B @ summed,
        parts_law.B @ W,
        np.vstack([parts_law.C + parts_law.D @ summed, summed[inputs_only]]),
        np.vstack([parts_law.D @ W, W[inputs_only]]),
        parts[0].law.sample_time,
    )
    notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
    return LinearComponent(law, inputs, (*outputs, *(inputs[k] for k in inputs_only)), notes=notes)


def _is_solvable(matrix: Array) -> bool:
    """Return whether a matrix can be inverted; the result does not depend on the units of its signals."""
    if not matrix.size:
        return True
    sizes = np.linalg.svd(matrix_balance(matrix, permute=False)[0], compute_uv=False)
    return bool(sizes.min() > WELL_POSED * sizes.max())


def sampled(part: LinearComponent, sample_time: float, late: Mapping[str, float] | None = None) -> LinearComponent:
    """Return the discrete-time form of a continuous part whose inputs are held over each sample (`held`).

    Parameters
    ----------
    part
        The continuous part.
    sample_time
        T (s).
    late
        Delay f of each input as a fraction of a sample, by the name of the input; 0 by default.
    """
    law = part.law
    shares = np.array([(late or {}).get(name, 0.0) for name in part.inputs])
    Phi, Gamma_0, Gamma_1 = held(law.A, law.B, sample_time, shares)
    is_late = shares > 0.0
    n_late = int(is_late.sum())
    A = np.block([[Phi, Gamma_1[:, is_late]], [np.zeros((n_late, len(Phi) + n_late))]])
    B = np.vstack([Gamma_0, np.eye(len(shares))[is_late]])
    C, D = np.hstack([law.C, law.D[:, is_late]]), np.where(is_late, 0.0, law.D)
    return LinearComponent(Law(A, B, C, D, sample_time), part.inputs, part.outputs, notes=part.notes)


def held(A: NDArray[Any], B: NDArray[Any], time: float, late: Array) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return Phi, Gamma_0 and Gamma_1 of x(n+1) = Phi x(n) + Gamma_0 u(n) + Gamma_1 u(n-1), with held inputs u.

    Gamma_1 = Phi((1 - f) T) Gamma(f T),  Gamma_0 = Gamma((1 - f) T)

    Parameters
    ----------
    A, B
        Matrices of x' = A x + B u, real or complex.
    time
        T (s).
    late
        Delay f of each input as a fraction of T, shape (n_inputs,).
    """
    Phi, now = zoh(A, B, time)
    before = np.zeros_like(now)
    for f in np.unique(late[late > 0.0]):
        columns = late == f
        Gamma_before = zoh(A, B[:, columns], f * time)[1]
        Phi_after, now[:, columns] = zoh(A, B[:, columns], (1.0 - f) * time)
        before[:, columns] = Phi_after @ Gamma_before
    return Phi, now, before


def zoh(A: NDArray[Any], B: NDArray[Any], time: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return Phi and Gamma of x(t + time) = Phi x(t) + Gamma u, with inputs u that are held for `time` (s)."""
    n, m = B.shape
    held_inputs = np.zeros((n + m, n + m), np.result_type(A, B))
    held_inputs[:n] = np.hstack([A, B]) * time
    exponential = expm(held_inputs)
    return exponential[:n, :n], exponential[:n, n:]


def delayed_by_a_step(part: LinearComponent, names: Sequence[str]) -> tuple[LinearComponent, dict[str, str]]:
    """Add copies of some outputs, delayed by one step, to a sampled part; return the part and the copies' names."""
    later = {name: f"{name} (before)" for name in names}
    rows = [part.outputs.index(name) for name in later]
    law, n, p = part.law, len(part.law.A), len(rows)
    A = np.block([[law.A, np.zeros((n, p))], [law.C[rows], np.zeros((p, p))]])
    C = np.block([[law.C, np.zeros((len(law.C), p))], [np.zeros((p, n)), np.eye(p)]])
    B, D = np.vstack([law.B, law.D[rows]]), np.vstack([law.D, np.zeros((p, law.D.shape[1]))])
    outputs = (*part.outputs, *later.values())
    return LinearComponent(Law(A, B, C, D, law.sample_time), part.inputs, outputs, part.late, part.notes), later


def in_order(
    parts: Sequence[LinearComponent], feeds: Mapping[str, str], names: Sequence[str]
) -> tuple[list[LinearComponent], dict[str, str]]:
    """Return parts and feeds, with a delay of one step wherever an `at_end` part feeds itself or an earlier part."""
    place = {name: k for k, name in enumerate(names)}
    result, changed = list(parts), dict(feeds)
    for k, part in enumerate(parts):
        if not part.at_end:
            continue
        back = [(t, s) for t, s in feeds.items() if s in part.outputs and place[t.partition(".")[0]] <= k]
        if back:
            result[k], later = delayed_by_a_step(part, [s for _, s in back])
            changed |= {target: later[source] for target, source in back}
    return result, changed


def loop_of(
    parts: Sequence[LinearComponent], feeds: Mapping[str, str], opened: Mapping[str, str] | None = None
) -> LinearComponent:
    """Connect all parts; if any part is sampled, the continuous parts are sampled with its sample time.

    If a demand is late by a fraction f of a sample, a signal injected at the input that the demand feeds is late by the
    same fraction. The sum w at this input therefore gives the sensitivity, and an opened loop contains the whole delay.
    For a controller K and a plant P that includes the delay,

        w(n) = u(n) + e(n),    w = (1 - K P)^-1 e;    u = K P e if opened                           (2)

    Parameters
    ----------
    parts, feeds
        As for `connected`, but sampled and continuous parts may be mixed.
    opened
        Connections that are cut: the output that would feed each input, by the name of the input.

    Raises
    ------
    ValueError
        As for `connected`, or if parts have different sample times.
    """
    discrete = [part for part in parts if part.law.sample_time is not None]
    continuous = [part for part in parts if part.law.sample_time is None]
    if not discrete:
        return connected(continuous, within(continuous, feeds))
    times = sorted({part.law.sample_time or 0.0 for part in discrete})
    if times[-1] > times[0] * (1.0 + 1e-9):
        raise ValueError(
            f"components with sample times of {', '.join(f'{time:g} s' for time in times)} are not allowed; a "
            f"linear model must have a single sample time"
        )
    if not continuous:
        return connected(discrete, within(discrete, feeds))
    shares = {name: part.late for part in discrete if part.late > 0.0 for name in part.outputs}
    links = within(parts, {**feeds, **(opened or {})})
    inside = {name for part in continuous for name in part.inputs}
    late = {target: shares[source] for target, source in links.items() if target in inside and source in shares}
    solved = within(continuous, feeds)
    machine = sampled(connected(continuous, solved), times[0], late)
    machine = machine.selected(machine.inputs, [name for name in machine.outputs if name not in late])
    together = [machine, *discrete]
    return connected(together, within(together, {k: v for k, v in feeds.items() if k not in solved}))


def within(parts: Sequence[LinearComponent], feeds: Mapping[str, str]) -> dict[str, str]:
    """Return the feeds whose input and output both belong to the parts."""
    inputs = {name for part in parts for name in part.inputs}
    outputs = {name for part in parts for name in part.outputs}
    return {target: source for target, source in feeds.items() if target in inputs and source in outputs}
