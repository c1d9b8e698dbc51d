"""Search on the sampled loop for a first PID: the stiffness and damping of each bearing, and the derivative's filter.

The search minimises the sum of all shortfalls from targets (index w):

    4 sum max(0, |S|/S_w - 1) + sum max(0, 1 - zeta/zeta_w) + sum max(0, k_w/k - 1),   k = K_b/K_s      (1)

The first sum includes the largest |S| up to 2 kHz and above 2 kHz. The second includes the smallest damping ratio of
the vibrations in each of three frequency bands: within the range of speed, up to twice the trip speed, and above. The
third includes the stiffness of each bearing. At low frequency, |S| is K_s/K_b, and the rotor drifts away if the
negative stiffness of the magnets exceeds the K_b + K_s of the controller.

The loop includes all modes that the sample rate resolves. In runs, however, the rotor has only the modes of its file's
[reduction] and residual shapes. Control can drive these shapes although they are not modes. Therefore, (1) also
includes the vibrations of the rotor in runs; otherwise, scenarios of a good design could be unstable.

The search first evaluates a grid with the same ratios in all bearings, and then starts simplex searches from its best
points (J. A. Nelder, R. Mead, Computer Journal 7 (1965) 308-313). The search uses no random numbers, so a drawing
always yields the same design.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, minimize

from amb_analysis.linear.loop import Loop
from amb_analysis.machine.machine import Machine
from amb_analysis.studies.loop_vibrations import vibrations_over
from amb_analysis.studies.stability_margin import zone
from amb_assessment.first_design.loop_search import LoopSearch, Peak, damping_ratios, largest_peaks
from amb_assessment.first_design.sizing import MachineSizes
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import RPM
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linearisation, static_current_for
from amb_cosim.results.component_names import CONTROLLER
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from array_types import Array
from rotor_analysis.rotor import Rotor

STIFFNESSES = (0.75, 1.1, 1.6)  # k = K_b/K_s of the grid
LEADS = (0.4, 0.8, 1.6, 3.2)  # C_b/(K_b + K_s) of the grid, in `lead_unit`
LEAD, DRIFTS = 1e-3, (200.0, 1000.0)  # s, and rates sqrt(K_s/m) of magnets (rad/s) between which it is the unit
FILTERS = (0.2, 2.0)  # derivative's filter of the grid, over the sample time
TRIP = 1.05  # trip speed over the highest speed, as in machine files
SEARCHED = (0.0, 0.6, TRIP)  # speeds of the search over the highest
JUDGED = (0.0, 0.4, 0.8, 1.0, TRIP)  # first speeds of the verdict over the highest
RANGE = 1.2  # highest frequency that unbalance excites, over the highest speed
WITHIN_RANGE, WITHIN_TWICE, BEYOND = 0.1, 0.02, 0.002  # wanted damping ratios
MODES = 20  # of the rotor whose damping is examined
LEFT = 0.5  # share of the rotor's damping that is wanted beyond, if that is less than `BEYOND`
PEAK, PEAK_BEYOND = 2.6, 4.0  # wanted |S| up to 2 kHz, with reserve to zone A, and above
OF_PEAKS = 4.0  # weight of the sensitivities in (1)
STIFFNESS = 0.7  # wanted K_b/K_s: |S| is then 3.8 at rest with 15 % more K_s, 10 % less K_i and 5 % less gap
BOUNDS = ((0.3, 5.0), (0.1, 8.0), (0.02, 20.0))  # of k, leads and filters of the search
STARTS, EVALUATIONS = 2, 120  # of simplex searches, from the best of the grid; of each
UNSTABLE = 1e3  # value of (1) for an unstable loop
BANDS = ("within the range of speed", "up to twice the trip speed", "beyond")


@dataclass(frozen=True)
class OperatingPoint:
    """Currents (A), K_s (N/m) and K_i (N/A) of an axis that carries its share of the weight.

    The upper coils carry the weight and have the bias current plus the static current; the lower coils have the bias
    current.
    """

    bias_current: float
    static_current: float
    k_s: float
    k_i: float

    @property
    def coils(self) -> tuple[float, float]:
        """Currents of the upper and of the lower coils (A)."""
        return self.bias_current + self.static_current, self.bias_current


@dataclass(frozen=True)
class Pid:
    """Stiffness (N/m) and damping (N s/m) of each bearing in closed loop, and time constant of the derivative (s)."""

    k_b: dict[str, float]
    c_b: dict[str, float]
    derivative_time: float

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the controller by name."""
        gains = {"k_b": self.k_b, "c_b": self.c_b}
        axes = {f"{b}.{name}_{a}": value for name, values in gains.items() for b, value in values.items() for a in "xy"}
        return {**axes, "derivative_time": self.derivative_time}


@dataclass(frozen=True)
class Levitation:
    """Behaviour of the sampled loop from standstill to the trip speed.

    in_range, within_twice, beyond
        Smallest damping ratios of vibrations in three frequency bands: up to 1.2 times the highest speed, where
        unbalance excites them; up to twice the trip speed; and above.
    frequency, speed
        Frequency and spin speed of the vibration that is furthest below its target, or of the growing motion.
    peak, peak_beyond
        Largest sensitivity up to 2 kHz, and above 2 kHz; infinite if the loop is not stable.
    wanted
        Wanted damping ratios in the three bands.
    motion
        The growing motion in words; empty if the loop is stable.
    motion_in_runs
        The motion that grows in runs, in words; empty if none grows. In runs, the rotor has only the modes of its
        file's [reduction].
    """

    in_range: float
    within_twice: float
    beyond: float
    frequency: Annotated[float, "rad/s"]
    speed: Annotated[float, "rad/s"]
    peak: Peak
    peak_beyond: Peak
    wanted: tuple[float, float, float]
    motion: str = ""
    motion_in_runs: str = ""

    @property
    def is_stable(self) -> bool:
        """Whether no motion grows."""
        return not self.motion

    @property
    def holds(self) -> bool:
        """Whether no motion grows, either in the loop with all modes or in runs."""
        return not (self.motion or self.motion_in_runs)

    @property
    def zone(self) -> str:
        """Zone of ISO 14839-3 to which the largest sensitivity belongs."""
        return zone(self.peak.value)

    @property
    def least_damped(self) -> str:
        """Description of the vibration that is furthest below its target, or of the growing motion."""
        what = self.motion or f"the vibration at {self.frequency / (2.0 * math.pi):.0f} Hz"
        return f"{what} at {self.speed * RPM:.0f} rpm"

    @property
    def damping(self) -> str:
        """Smallest damping ratio of each band that contains a vibration, in words."""
        bands = zip(BANDS, self.ratios, strict=True)
        return ", ".join(f"{zeta:.3g} {band}" for band, zeta in bands if zeta < 1.0)

    @property
    def lack(self) -> float:
        """The sum (1) for the loop with all modes, without the stiffness terms; 0 if all targets are met."""
        return _lack(self.peak.value, self.peak_beyond.value, self.ratios, self.wanted) if self.holds else UNSTABLE

    @property
    def ratios(self) -> tuple[float, float, float]:
        """Smallest damping ratios in the three bands."""
        return self.in_range, self.within_twice, self.beyond


def operating_points(sizes: MachineSizes) -> dict[str, OperatingPoint]:
    """Return the operating point of each bearing's axes."""
    return {bearing: _point(sizes, bearing, load) for bearing, load in sizes.loads.items()}


def _point(sizes: MachineSizes, bearing: str, load: float) -> OperatingPoint:
    names = ("turns", "pole_area", "gap", "bias_current", "current_limit")
    p = axis_parameters(**{name: getattr(sizes, name) for name in names}, static_current=0.0)
    if bearing in sizes.coils:
        coils = sizes.coils[bearing]
        p.bias_current, p.pole_area = coils.bias_current, coils.pole_area
    p.static_current = static_current_for(abs(load), p)  # of the coil pair that carries it, whichever that is
    at_rest = linearisation(p)
    return OperatingPoint(float(p.bias_current), float(p.static_current), float(at_rest.k_s), float(at_rest.k_i))


def lead_unit(sizes: MachineSizes) -> float:
    """Return the time (s) in which the search measures leads: 1 ms, scaled with slow or fast magnets.

    Without control, a rotor leaves the centre of its magnets at the rate sqrt(K_s/m). The lead that holds it is
    proportional to the reciprocal of this rate.
    """
    k_s = [point.k_s for point in operating_points(sizes).values()]
    rate = math.sqrt(max(k_s) * len(k_s) / sizes.mass)
    slow, fast = DRIFTS
    return LEAD * min(max(rate, slow), fast) / rate


def pid_of(k_s: dict[str, float], ratios: Sequence[float], sample_time: float, unit: float = LEAD) -> Pid:
    """Return the PID with K_b = k K_s and C_b = t (K_b + K_s).

    Parameters
    ----------
    k_s
        K_s of the bearings (N/m).
    ratios
        k (1) and t (in `unit`) of each bearing, followed by the derivative's time constant divided by the sample time.
    sample_time, unit
        Sample time of the controller (s), and unit of t (s; see `lead_unit`).
    """
    k, lead = np.reshape(ratios[:-1], (-1, 2)).T
    k_b = {bearing: float(k[n] * value) for n, (bearing, value) in enumerate(k_s.items())}
    c_b = {bearing: float(unit * lead[n] * (k_b[bearing] + value)) for n, (bearing, value) in enumerate(k_s.items())}
    return Pid(k_b, c_b, float(ratios[-1] * sample_time))


def wanted_ratios(rotor: Rotor) -> tuple[float, float, float]:
    """Return the wanted damping ratios in the three bands; the last is at most half the damping ratio of the rotor."""
    rotor_ratio = float(rotor.damping.ratios(MODES).min())
    return WITHIN_RANGE, WITHIN_TWICE, min(BEYOND, LEFT * rotor_ratio) if rotor_ratio > 0.0 else BEYOND


def levitation_of(loop: Loop, speed: float, pid: Pid, wanted: tuple[float, float, float]) -> Levitation:
    """Return the behaviour of the sampled loop with a PID, up to the trip speed.

    Parameters
    ----------
    loop
        Loop of the machine with these gains.
    speed
        Highest speed in operation (rad/s).
    pid
        The gains.
    wanted
        Wanted damping ratios (`wanted_ratios`).
    """
    speeds = speed * np.array(JUDGED)
    closer, at_speeds = vibrations_over(loop, speeds, lambda v: _least(v.poles.imag, v.ratios(), speed))
    worst = max((v.stability for v in at_speeds), key=lambda stability: stability.radius)
    if not worst.is_stable:
        lost = Peak(math.inf, worst.place, worst.frequency / (2.0 * math.pi), worst.speed)
        ratio = -worst.growth_rate / math.hypot(worst.growth_rate, worst.frequency)
        return Levitation(ratio, ratio, ratio, worst.frequency, worst.speed, lost, lost, wanted, worst.motion)
    zetas, omegas = (
        np.concatenate(parts) for parts in zip(*((v.ratios(), v.poles.imag) for v in at_speeds), strict=True)
    )
    spins = np.repeat(closer, [len(v.poles) for v in at_speeds])
    least = sum(within * zeta for within, zeta in zip(_bands(omegas, speed), wanted, strict=True))
    furthest = int((zetas / least).argmin())
    peaks = largest_peaks(loop, pid.parameters, speeds)
    return Levitation(*_least(omegas, zetas, speed), float(omegas[furthest]), float(spins[furthest]), *peaks, wanted)


def growth_in_runs(loop: Loop, speed: float) -> str:
    """Return the fastest-growing motion of the loop in runs up to the trip speed, in words; "" if no motion grows."""
    worst = max((loop.poles(share * speed).stability for share in JUDGED), key=lambda stability: stability.radius)
    return "" if worst.is_stable else f"{worst.motion} at {worst.speed * RPM:.0f} rpm"


class _End(NamedTuple):
    """The result of a search: ratios (`pid_of`), and the sum (1)."""

    ratios: Array
    lack: float


class Designer:
    """Designs the PID of a machine.

    Parameters
    ----------
    scenario
        Scenario of the machine, with any gains.
    sizes
        Sizes of the magnets.
    options
        Options of its linearisation; only the flavour of the FMUs is used.
    progress
        Function that is called with the number of sets of gains tried.
    """

    def __init__(
        self, scenario: Scenario, sizes: MachineSizes, options: RunOptions, progress: Callable[[int], None]
    ) -> None:
        self._scenario, self._options, self.speed = scenario, options, sizes.speed
        self._progress, self._tried = progress, 0
        self._k_s = {bearing: point.k_s for bearing, point in operating_points(sizes).items()}
        self._unit = lead_unit(sizes)
        self.wanted = wanted_ratios(sizes.rotor)

    @cached_property
    def _searches(self) -> tuple[LoopSearch, LoopSearch]:
        """The loop with all modes, and the loop as simulated in runs."""
        machine, speeds = self.machine(), [share * self.speed for share in SEARCHED]
        return LoopSearch(machine.loop, speeds), LoopSearch(machine.run_loop, speeds)

    def machine(self, pid: Pid | None = None) -> Machine:
        """Return the machine with the gains of a PID, by default those of the scenario."""
        values = {} if pid is None else {f"{CONTROLLER}.{name}": value for name, value in pid.parameters.items()}
        return Machine(prepare_run(self._scenario.machine(), values, options=self._options))

    def best(self) -> Pid:
        """Return the best PID, or the first that meets all targets."""
        grid = {ratios: self.lack(ratios) for ratios in product(STIFFNESSES, LEADS, FILTERS)}
        n, ends = len(self._k_s), []
        for k, lead, tau in sorted(grid, key=lambda ratios: grid[ratios])[:STARTS]:
            ends.append(self._refined([*[k, lead] * n, tau]))
            if ends[-1].lack == 0.0:
                return self.pid(ends[-1].ratios)
        best = min(ends, key=lambda end: end.lack)
        return self.pid(self._refined(best.ratios).ratios)

    def _refined(self, ratios: Sequence[float] | Array) -> _End:
        """Return the result of a simplex search that starts from `ratios` and stops when all targets are met."""
        bounds = [*BOUNDS[:2]] * len(self._k_s) + [BOUNDS[2]]

        def stop(intermediate_result: OptimizeResult) -> None:
            if intermediate_result.fun <= 0.0:
                raise StopIteration

        result = minimize(
            lambda x: self.lack(np.exp(x)),
            np.log(ratios),
            method="Nelder-Mead",
            bounds=np.log(bounds),
            callback=stop,
            options={"maxfev": EVALUATIONS, "xatol": 0.01, "fatol": 1e-3},
        )
        return _End(np.exp(result.x), float(result.fun))

    def pid(self, ratios: Sequence[float] | Array) -> Pid:
        """Return the PID for `ratios` (`pid_of`); a single pair of stiffness and lead is used for all bearings."""
        *of_bearings, tau = np.asarray(ratios, dtype=float)
        repeated = of_bearings * (len(self._k_s) if len(of_bearings) == 2 else 1)
        return pid_of(self._k_s, [*repeated, tau], self._searches[0].sample_time, self._unit)

    def lack(self, ratios: Sequence[float] | Array) -> float:
        """Return the sum (1) for `ratios` (`pid_of`).

        For an unstable loop, the value is `UNSTABLE` or more, and it increases with the spectral radius.
        """
        self._tried += 1
        self._progress(self._tried)
        pid, (search, of_runs) = self.pid(ratios), self._searches
        law = search.law(pid.parameters)
        poles = search.poles(law)
        all_poles = [*poles, *of_runs.poles(of_runs.law(pid.parameters))]
        radius = max(float(np.abs(z).max()) for z in all_poles)
        if radius >= 1.0:
            return UNSTABLE * (1.0 + math.log(radius))
        omegas, zetas = np.hstack([damping_ratios(z, search.sample_time) for z in all_poles])
        k = np.array([pid.k_b[bearing] / k_s for bearing, k_s in self._k_s.items()])
        soft = float(np.maximum(STIFFNESS / k - 1.0, 0.0).sum())
        return soft + _lack(*search.coarse_peaks(law, poles), _least(omegas, zetas, self.speed), self.wanted)


def _lack(peak: float, peak_beyond: float, ratios: Sequence[float], wanted: Sequence[float]) -> float:
    """Return the part of the sum (1) that is due to sensitivities and damping ratios."""
    excess = max(0.0, peak / PEAK - 1.0) + max(0.0, peak_beyond / PEAK_BEYOND - 1.0)
    return OF_PEAKS * excess + sum(max(0.0, 1.0 - zeta / least) for zeta, least in zip(ratios, wanted, strict=True))


def _bands(omegas: Array, speed: float) -> list[NDArray[np.bool_]]:
    """Return masks of frequencies (rad/s): in the range of speed, up to twice the trip speed, and above that speed."""
    low, judged = omegas <= RANGE * speed, omegas <= 2.0 * TRIP * speed
    return [low, judged & ~low, ~judged & ~low]


def _least(omegas: Array, zetas: Array, speed: float) -> tuple[float, float, float]:
    """Return the smallest damping ratio in each band, or 1 for a band without vibrations."""
    first, second, third = (float(zetas[within].min(initial=1.0)) for within in _bands(omegas, speed))
    return first, second, third
