"""The settled motion of a system at constant speed, found by solving equations instead of by simulation.

With x the states and signals that move linearly, a communication step is

    x(n+1) = T x(n) + F_0 + Re[F_1 exp(j theta_n)]          theta_(n+1) = theta_n + phi                     (1)

T, F_0 and F_1 are found from the FMUs themselves. Each FMU is stepped from a saved state with one number changed at a
time (`responses`), and the responses are combined in the order of the master. If T is stable, (1) settles to

    x(n) = a + Re[b exp(j theta_n)]      (1 - T) a = F_0      (exp(j phi) - T) b = F_1                      (2)

No period is assumed: a turn may take any number of steps. The residual of a step from (2) is used to correct a and b
once, which removes the rounding errors of T. Nonlinear states (Fourier windows, counters, the key of the exact motion)
are found by simulating one turn. At the end of this turn, each signal must agree with (2); contact, noise, limits and
nonlinear laws are thus detected.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from amb_cosim.cosim.errors import FmuError, StepFailed
from amb_cosim.cosim.fmu.component import FmuComponent
from amb_cosim.cosim.master.master import Master
from amb_cosim.cosim.master.responses import ANGLES, Response, StateMap, first_harmonic
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.cosim.system.experiment import WARM_UP
from array_types import Array, Bools, Indices

Advance = Callable[[int, int], None]

TOLERANCE = 1e-9  # of the largest signal of the same unit
DOUBLINGS = 24  # of the number of steps within which the powers of T must vanish


class CannotSettle(Exception):
    """The equations of the settled motion cannot be set up or solved; the message gives the reason."""


class _OffOrbit(Exception):
    """A signal deviates from the computed motion."""


@dataclass(frozen=True)
class SettledLoop:
    """A master at communication point n, the `StateMap` of each component as a part, and masks of the values that move.

    `moving` selects the values that move linearly, and `turning` the angles. `advance` steps the master from one point
    to another.
    """

    master: Master[FmuComponent]
    advance: Advance
    parts: Sequence[StateMap]
    moving: Bools
    turning: Bools
    n: int

    @cached_property
    def signals(self) -> Indices:
        """Positions of the values that move linearly."""
        return np.flatnonzero(self.moving)

    @cached_property
    def names(self) -> list[str]:
        """Names of the signals that move linearly."""
        return [self.master.wiring.names[position] for position in self.signals]

    @cached_property
    def units(self) -> list[str | None]:
        """Units of the signals that move linearly."""
        ports = {part.component.name: part.interface.ports for part in self.parts}
        return [ports[component][variable].unit for component, _, variable in (n.partition(".") for n in self.names)]

    @property
    def n_states(self) -> int:
        """The number of states, which precede the signals in x."""
        return sum(len(part.rows) for part in self.parts)

    @cached_property
    def _places(self) -> list[tuple[Indices, Indices]]:
        """Memory indices of the moving signals in each part, and the positions of these signals."""
        return [part.places_of(self.moving | self.turning) for part in self.parts]

    def put(self, x: Array, angle: float) -> None:
        """Set the states, the signals and the angle (rad) of the master and its parts at point n."""
        values = self.master.values
        values[self.signals], values[self.turning] = x[self.n_states :], angle
        row = 0
        for part, (places, positions) in zip(self.parts, self._places, strict=True):
            part.start(x[row : row + len(part.rows)], places, values[positions], angle)
            row += len(part.rows)

    def step(self) -> Array:
        """Step from point n, and return the states and signals."""
        self.advance(self.n, self.n + 1)
        states = (part.component.present()[part.rows] for part in self.parts)
        return np.concatenate([*states, self.master.values[self.signals]])

    def responses(self) -> list[Response]:
        """Find the response of each part."""
        time, step_size = self.master.time(self.n), self.master.step_size
        scales = np.abs(self.master.values)
        return [part.response(self.moving, self.turning, scales, time, step_size) for part in self.parts]

    def single_step(self, responses: Sequence[Response]) -> tuple[Array, Array]:
        """Return T of (1), and the constant, cosine and sine parts of F, shape (n_x, 3)."""
        n_states, row = self.n_states, 0
        size = n_states + len(self.signals)
        before = np.hstack([np.eye(size), np.zeros((size, 3))])
        after = before.copy()
        for part, response in zip(self.parts, responses, strict=True):
            rows = np.arange(row, row + len(part.rows))
            fed, observed = (
                n_states + np.searchsorted(self.signals, positions[self.moving[positions]])
                for positions in (part.sources, part.slot)
            )
            seen = before if self.master.coupling == "jacobi" else after
            answer = response.matrix @ np.vstack([before[rows], seen[fed]])
            answer[:, size:] += response.forcing
            after[np.concatenate([rows, observed])] = answer
            row += len(rows)
        return after[:, :size], after[:, size:]


@dataclass(frozen=True)
class Orbit:
    """The settled motion (2): a, b (complex), the angle at communication point `n` (rad), and phi (rad)."""

    mean: Array
    amplitude: Array
    n: int
    angle: float
    advance: float

    def angle_at(self, n: int) -> float:
        """Return theta at communication point n, from 0 to 2 pi (rad)."""
        return (self.angle + (n - self.n) * self.advance) % (2.0 * math.pi)

    def at(self, angle: float) -> Array:
        """Return x at an angle (rad)."""
        x: Array = self.mean + (self.amplitude * np.exp(1j * angle)).real
        return x


def settle(master: Master[FmuComponent], assembly: Assembly, advance: Advance, first: int, begin: int) -> int:
    """Bring a master into its settled motion, and return the communication point then reached, which precedes point 0.

    Parameters
    ----------
    master, assembly
        The master, which is initialised at point `begin`, and the FMUs and interfaces of its components.
    advance
        Function that steps the master from one point to another.
    first
        Point since which the angle is assumed to have increased; this determines the angle at point 0.
    begin
        See `Plan.begin`.

    Raises
    ------
    CannotSettle
        If no settled motion exists, or it cannot be solved for.
    """
    n = begin + WARM_UP
    parts: Sequence[StateMap] = ()
    try:
        advance(begin, n)
        loop = loop_at(master, assembly, advance, n)
        parts = loop.parts
        orbit = solve(loop, loop.responses(), begin - first)
        loop.put(orbit.at(orbit.angle), orbit.angle)
        loop.step()
        _check(loop, orbit, n + 2)
        for part in parts:
            part.balance_energy()
        advance(n + 2, -1)
        _check(loop, orbit, -1)
    except (FmuError, StepFailed) as error:
        raise CannotSettle(str(error)) from error
    except _OffOrbit as error:
        for part in parts:
            part.component.save()
        _refuse_active_nonlinearity(parts)
        raise CannotSettle(str(error)) from error
    return -1


def loop_at(master: Master[FmuComponent], assembly: Assembly, advance: Advance, n: int) -> SettledLoop:
    """Step a master from point n and return its loop at the next point; arguments are as for `settle`.

    Raises
    ------
    CannotSettle
        If an FMU does not declare its linear part, or a nonlinear feature is on.
    FmuError, StepFailed
        If an FMU refuses.
    """
    unable = [c.name for c in master.components if assembly.fmus[c.name].linear_state is None]
    if unable:
        raise CannotSettle(f"the FMU of {unable[0]} does not declare which part of its state moves linearly")
    if master.coupling == "iterative":
        raise CannotSettle("iterative coupling repeats steps")
    before = master.values.copy()
    advance(n, n + 1)
    parts = []
    for component, sources, slot in zip(master.components, master.wiring.sources, master.slots, strict=True):
        name = component.name
        exchanged = master.wiring.inputs[name], master.wiring.outputs[name]
        positions = sources, np.arange(len(before))[slot]
        linear_state = assembly.fmus[name].linear_state or {}
        parts.append(StateMap(component, assembly.interfaces[name], exchanged, positions, linear_state))
    _refuse_active_nonlinearity(parts)
    moved, is_angle = np.zeros(len(before), np.bool_), master.values == _turning(parts).angle
    moved[np.concatenate(master.wiring.sources)] = True
    moved &= master.values != before
    moved[: master.wiring.n_exogenous] = False
    return SettledLoop(master, advance, parts, moved & ~is_angle, moved & is_angle, n + 1)


def solve(
    loop: SettledLoop, responses: Sequence[Response], skipped: int, corrects: bool = True, advance: float | None = None
) -> Orbit:
    """Solve for the motion (2).

    Parameters
    ----------
    loop, responses
        The loop, and the response of each part.
    skipped
        Number of steps in which the rotor turns from its present angle to the angle of the orbit.
    corrects
        Whether the residual of a step corrects the motion; false if there are forces that the FMUs lack in free motion.
    advance
        Angle by which the motion turns in a step (rad); by default, the angle by which the rotor turns.

    Raises
    ------
    CannotSettle
        If the loop is not stable.
    """
    turning = _turning(loop.parts)
    T, forcing = loop.single_step(responses)
    check_stability(T, loop.master.step_size)
    advance = turning.advance(loop.master.time(loop.n), loop.master.step_size) if advance is None else advance
    angle = ((turning.angle or 0.0) + skipped * advance) % (2.0 * math.pi)
    steady, turned = np.eye(len(T)) - T, np.exp(1j * advance) * np.eye(len(T)) - T

    def corrected(orbit: Orbit, residual: Array) -> Orbit:
        constant, cosine, sine = residual.T
        mean = orbit.mean + np.linalg.solve(steady, constant)
        return replace(orbit, mean=mean, amplitude=orbit.amplitude + np.linalg.solve(turned, cosine - 1j * sine))

    rest = Orbit(np.zeros(len(T)), np.zeros(len(T), np.complex128), loop.n, angle, advance)
    orbit = corrected(rest, forcing)
    return corrected(orbit, _residual(loop, orbit)) if corrects else orbit


def _residual(loop: SettledLoop, orbit: Orbit) -> Array:
    """Return the constant, cosine and sine parts of the residual of an orbit after a step, shape (n_x, 3)."""
    residual = []
    for angle in ANGLES:
        loop.put(orbit.at(angle), angle)
        residual.append(loop.step() - orbit.at(angle + orbit.advance))
    return first_harmonic(np.array(residual))


def check_stability(T: Array, step_size: float) -> None:
    """Raise CannotSettle unless the powers of T tend to zero; `step_size` is the size of a step (s)."""
    moves = T.any(axis=0)  # what no step reads does not change whether the powers vanish
    power, size = T[np.ix_(moves, moves)], math.inf
    with np.errstate(all="ignore"):
        for _ in range(DOUBLINGS):
            power = power @ power
            size = float(np.abs(power).max(initial=0.0))
            if not 1e-6 < size < 1e12:
                break
    if size < 1.0:
        return
    worst = max(np.linalg.eigvals(T), key=abs)
    frequency = abs(np.angle(worst)) / (2.0 * math.pi * step_size)
    raise CannotSettle(
        f"the loop is not stable: a vibration of {frequency:.1f} Hz changes by the factor {abs(worst):.9g} per step"
    )


def _turning(parts: Sequence[StateMap]) -> StateMap:
    """Return the part that has an angle; raises CannotSettle unless there is exactly one such part."""
    turning = [part for part in parts if part.angle is not None]
    if len(turning) != 1:
        raise CannotSettle(f"{len(turning)} components output a rotor angle; there must be exactly one")
    return turning[0]


def _refuse_active_nonlinearity(parts: Sequence[StateMap]) -> None:
    """Raise CannotSettle if a variable of a part has a value that makes the part nonlinear."""
    for part in parts:
        for port in (port for pattern in part.unless for port in part.interface.matching(pattern)):
            value = part.value(port.position)
            if value != 0.0:
                names = {number: name for name, number in port.items.items()}
                text = "true" if port.type == "Boolean" else names.get(int(value), f"{value:g}{port.display_unit}")
                raise CannotSettle(f"{part.component.name}.{port.name} = {text} before cycle 0")


def _check(loop: SettledLoop, orbit: Orbit, n: int) -> None:
    """Raise _OffOrbit unless all signals agree with the orbit at point n."""
    names, units = loop.names, loop.units
    sizes = (np.abs(orbit.mean) + np.abs(orbit.amplitude))[loop.n_states :]
    largest = dict.fromkeys(units, 0.0)
    for unit, size in zip(units, sizes, strict=True):
        largest[unit] = max(largest[unit], size)
    expected = orbit.at(orbit.angle_at(n))[loop.n_states :]
    deviation = np.abs(loop.master.values[loop.signals] - expected) / [largest[unit] or 1.0 for unit in units]
    if np.all(deviation <= TOLERANCE):
        return
    worst = int(np.argmax(np.where(np.isnan(deviation), np.inf, deviation)))
    raise _OffOrbit(
        f"{names[worst]} does not move linearly: it deviates from the computed motion by {deviation[worst]:.2g} of the "
        f"largest signal in the same unit; possible causes are noise, nonlinear forces and limits"
    )
