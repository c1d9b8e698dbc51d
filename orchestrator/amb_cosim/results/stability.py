"""Whether a levitated rotor diverges at the end of a run, and why.

The loop of the machine is unstable if one of its poles grows. If all components of the loop have linear models, its
poles at the end of the run are known (`results.loop_stability`), and neither the length of the run, nor its excitation,
nor its record matters. An unstable loop need not show in the motion: a mode that nothing excites stays at rest.

The motion itself shows what the poles do not: growth at large amplitudes, where magnets are not linear, amplifiers that
stay at their limits, and a self-excited vibration that limits confine. It is all there is if a component has no
linear model. Only the end of the run is judged: the time since the last change, the last contact or cycle 0, whichever
is latest. This time must contain `MIN_CYCLES` turns, or as many periods of the vibration that grows. Growth is judged
only while all excitation from outside the rotor's loop is steady (`_last_change_outside`).
"""

from __future__ import annotations

import json

import numpy as np

from amb_cosim.cosim.choices import ROLES
from amb_cosim.cosim.record.signals import Signals, variables_of
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.units import length_unit, speed_unit
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, LIMITED, PLANT
from amb_cosim.results.free_vibration import free_vibration
from amb_cosim.results.growth import FEWEST, Growth, growing_part
from amb_cosim.results.loop_stability import LoopStability, stability_of_loop
from amb_cosim.results.orbits import radius
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import cycles, displacements, parameters, signal, speed, speed_changes, turns
from array_types import Array, Bools

LAST_CHANGE = "last_change_cycle"  # attribute of a data set: of the last event or point of the speed
SOURCES = "sources"  # attribute of a data set: components that excite the rotor from outside its loop, if any
EXCITATIONS = "excitations"  # attribute of a data set: the signals by which they do
MIN_CYCLES = 5.0
WIDENING = 0.02  # share by which the radius of an orbit that widens is larger in the last third of the time
LEAST_TURNS = 3.0  # after a change, of which each third of the time contains one
WIDE = 0.2  # of the clearance; an orbit that widens below it may still settle
PER_TURN = 8.0  # samples from which motion at other angles of the shaft is interpolated
GROWTH = 1.5  # of a mean square from the first to the last third of the time
ROUNDING = 1e-9  # cycles by which rounding may move a change at the last sample behind it
QUIET = 1.0  # cycles that a signal from outside is constant before it begins and after it ends
NOTICEABLE = 1e-4  # of the smallest clearance; smaller motion counts as rest
STEADY_SPEED = 0.01  # relative change that is ignored
LIMITED_SHARE = 0.5  # of the last cycles, beyond which an axis stays at its limits
OWN_SHARE, LASTING = 0.1, 0.9  # least rms of a vibration of its own, over that of all motion and over its rms before
PARTS = 4  # of the time, in each of which it reaches limits
RIG = 1.0  # value of `chain.preset` with all effects
_TESTING = f"{CONTROLLER}.identification_progress"


def instability(dataset: Signals, last_contact: float | None = None) -> str:
    """Return why the rotor diverges at the end of a run, as a clause; empty if nothing shows that it does.

    Parameters
    ----------
    last_contact
        Cycle of the last contact, or None.
    """
    loop = stability_of_loop(dataset)
    if loop is not None and not loop.is_stable:
        return f"its loop is unstable at {speed_unit().text(loop.speed)}: {loop.motion}"
    cycle = cycles(dataset)
    end, begin = float(cycle.max(initial=0.0)), _begin(dataset, last_contact)
    undisturbed = max(begin, _last_change_outside(dataset))
    growth = orbit_growth(dataset, _since(cycle, undisturbed))
    if growth is not None and max(end - undisturbed, growth.periods or 0.0) >= MIN_CYCLES:
        return f"its orbit grows: {_growth_text(dataset, growth, undisturbed)}"
    if end - begin < MIN_CYCLES:
        return ""
    if is_limited(dataset, _since(cycle, end - MIN_CYCLES)):
        return (
            f"an amplifier is at its limits in more than {100.0 * LIMITED_SHARE:g} % of the last {MIN_CYCLES:g} cycles"
        )
    if is_self_excited(dataset, _since(cycle, begin)):
        return "a vibration that the rotation does not force lasts, confined by the limits of the amplifiers"
    return ""


def too_short(dataset: Signals, last_contact: float | None = None) -> str:
    """Return why a run without contact is too short to show whether it stays free, as a clause; empty if it is not.

    If the loop is not known, its motion must last `MIN_CYCLES`. If the loop is stable, the orbit must not widen towards
    a clearance. With the largest radii P_1, P_2 and P_3 of the thirds of the time T since the last change, and the
    slowest decay sigma of the loop, it widens if P_1 < P_2 < P_3, up to

        P_3 + (P_3 - P_2) q/(1 - q),  q = (P_3 - P_2)/(P_2 - P_1) < 1;      P_3 coth(-sigma T/2)          (1)

    whichever is less. The first is the limit of a geometric series, the second that of a steady orbit and a transient
    that together start from rest. Orbits below `WIDE` of the clearance count only within `MIN_CYCLES` of an event.
    Thirds shorter than a turn do not show whether an orbit widens, so a wide one is then undecided.
    """
    cycle, begin, loop = cycles(dataset), _begin(dataset, last_contact), stability_of_loop(dataset)
    if not places(dataset).magnetic or not len(cycle):
        return ""
    if loop is None:
        lasts, period = float(cycle[-1]) - begin, float(dataset.attrs["period_s"])
        less = (
            f"it ends {lasts * period:.3g} s ({lasts:.3g} cycles) after the last change, and {MIN_CYCLES:g} are needed"
        )
        return less if 0.0 < lasts < MIN_CYCLES - ROUNDING else ""
    within = _since(cycle, begin)
    if SOURCES in dataset.attrs or speed_changes(dataset) or within.stop - within.start < FEWEST:
        return ""
    time, values = np.asarray(dataset["time"].values)[within], parameters(dataset)
    lasts = float(cycle[-1]) - begin
    is_recent = begin > 0.0 and lasts < MIN_CYCLES
    decay = max(-loop.growth_rate * float(time[-1] - time[0]), np.finfo(float).tiny)
    for site in places(dataset).sites:
        r, clearance = radius(dataset, site), values.get(f"{site}.clearance")
        if r is None or not clearance or not values.get(f"{site}.enabled", True):
            continue
        widest, largest = _widens_to(r[within], decay), float(r[within].max())
        if is_recent and lasts < LEAST_TURNS and largest > WIDE * clearance:
            reached = f"reaches {length_unit(clearance).text(largest, 3)} within {lasts:.2g} turns of the last change"
            return f"the orbit at {name_label(site)} {reached}, and {LEAST_TURNS:g} turns are needed"
        if widest is not None and widest >= clearance and (is_recent or largest > WIDE * clearance):
            reached = length_unit(clearance).text(largest, 3)
            return f"the orbit at {name_label(site)} still widens when the run ends, at {reached}"
    return ""


def judged_time(dataset: Signals, last_contact: float | None = None) -> float:
    """Return the time (s) at the end of a run in which growth would have shown; see `instability`."""
    begin = max(_begin(dataset, last_contact), _last_change_outside(dataset))
    return (float(cycles(dataset)[-1]) - begin) * float(dataset.attrs["period_s"])


def _widens_to(radii: Array, decay: float) -> float | None:
    """Return the radius (m) by (1) up to which an orbit widens, given its radii and -sigma T; None if it does not."""
    first, second, third = (float(part.max()) for part in np.array_split(radii, 3))
    if not first < second < third * (1.0 - WIDENING):
        return None
    q = (third - second) / (second - first)
    series = third + (third - second) * q / (1.0 - q) if q < 1.0 else np.inf
    return min(series, third / np.tanh(0.5 * decay))


def _begin(dataset: Signals, last_contact: float | None) -> float:
    """Return the cycle of the last change, the last contact or cycle 0, whichever is latest."""
    return max(last_contact or 0.0, last_change(dataset))


def _growth_text(dataset: Signals, growth: Growth, since: float) -> str:
    """Return the vibration and its growth since a cycle, in words."""
    cycle = cycles(dataset)
    time = np.asarray(dataset["time"].values)[_since(cycle, since)]
    lasts = float(time[-1] - time[0])
    rate = growth.growth / lasts
    if growth.periods is None:
        return f"a part of its motion grows by {rate:.3g} 1/s"
    return LoopStability(2.0, rate, 2.0 * np.pi * growth.periods / lasts).motion


def last_change(dataset: Signals) -> float:
    """Return the cycle of the last event or speed point within the run; 0 if there is none from cycle 0 on."""
    end = float(cycles(dataset).max(initial=0.0))
    events = (float(dataset.attrs.get(name, 0.0)) for name in (LAST_CHANGE, *(f"{role}_cycle" for role in ROLES)))
    return max(0.0, *(min(event, end) for event in events if event <= end + ROUNDING))


def _since(cycle: Array, begin: float) -> slice:
    """Return the samples after a cycle."""
    return slice(int(np.searchsorted(cycle, begin, "right")), len(cycle))


def orbit_growth(dataset: Signals, within: slice) -> Growth | None:
    """Return the growth of the part of the motion at the bearings that evidently grows; None if no part does.

    Steady orbits, drifts along a straight line, and orbits that approach another orbit do not grow (see
    `results.growth`). Samples are taken at equal angles of the shaft, so that a synchronous orbit appears steady while
    the speed varies by up to 1 %. The result is None if the speed changes by more than this, if a record of a changing
    speed has fewer than `PER_TURN` samples a turn, between which angles cannot be interpolated, or if an excitation
    from outside the loop is not steady. A slow sine sweep can be fitted by growing parts that cancel one another. If a
    component excites the rotor from outside its loop, the motion as a whole must therefore grow.

    Parameters
    ----------
    within
        Samples to judge, which contain no events, contact or test forces.
    """
    motion = _steadily_forced(dataset, within)
    if motion is None:
        return None
    Omega = _varying_speed(dataset)
    if Omega is not None and np.ptp(Omega[within]) > 0.0:
        if np.ptp(np.abs(turns(dataset)[within])) * PER_TURN > len(motion):
            return None
        motion = _at_equal_angles(np.asarray(dataset["time"].values)[within], np.asarray(Omega)[within], motion)
    if SOURCES in dataset.attrs:
        if not all(_is_steady(values[within]) for values in _excitations(dataset)):
            return None
        begin, _, end = np.array_split(motion - motion.mean(axis=0), 3)
        if not np.mean(end**2) > GROWTH * np.mean(begin**2):
            return None
    return growing_part(motion, NOTICEABLE * _least_clearance(dataset))


def _excitations(dataset: Signals) -> list[Array]:
    """Return the recorded signals that excite the rotor from outside its loop, shape (n,) each."""
    names = json.loads(dataset.attrs.get(EXCITATIONS, "[]"))
    return [np.asarray(dataset[name].values, dtype=float) for name in names if name in dataset]


def _last_change_outside(dataset: Signals) -> float:
    """Return the last cycle at which a signal from outside the loop began or ceased to be constant; 0 if none did."""
    cycle, last = cycles(dataset), 0.0
    for values in _excitations(dataset):
        at = cycle[1:][np.diff(values) != 0.0]
        quiet = np.diff(np.concatenate([cycle[:1], at, cycle[-1:]])) >= QUIET
        last = max(last, float(at[quiet[:-1] | quiet[1:]].max(initial=0.0)))
    return last


def _is_steady(values: Array) -> bool:
    """Return whether the mean squares of a signal and of its rate, which depends on its frequency, stay constant.

    For steady vibration or noise they agree in the first and the last third of the time to within a factor of `GROWTH`.
    For a signal that begins, grows, fades or sweeps, they differ by more.
    """
    for signal_or_rate in (values - values.mean(), np.diff(values)):
        first, _, last = (float(np.mean(part**2)) for part in np.array_split(signal_or_rate, 3))
        if max(first, last) > GROWTH * min(first, last):
            return False
    return True


def is_self_excited(dataset: Signals, within: slice) -> bool:
    """Return whether a vibration that is not periodic with the rotation persists and keeps reaching current limits.

    Rotation, weight and constant inputs force motion that is periodic with the rotation, even if it reaches limits. Any
    other vibration decays under a stable loop. A vibration that does not decay is driven by an unstable loop and
    bounded by the limits that it reaches. Such a vibration is a limit cycle, which may be at these limits for any share
    of the time. Vibrations are compared over two intervals of `MIN_CYCLES` or more. The result is false with sensor
    noise, which drives all vibrations, or with a component that excites the rotor from outside its loop, such as a
    generator of test forces.

    Parameters
    ----------
    within
        Samples to judge, which contain no events, contact or test forces.
    """
    limited = np.any(_limits(dataset, within), axis=0)
    if not all(part.any() for part in np.array_split(limited, PARTS)):
        return False
    motion, revolutions = _steadily_forced(dataset, within), np.abs(turns(dataset)[within])
    if motion is None or _is_noisy(dataset) or SOURCES in dataset.attrs:
        return False
    if np.ptp(cycles(dataset)[within]) * len(motion) / (len(motion) - 1) < 2.0 * MIN_CYCLES:
        return False
    own = free_vibration(motion, float(np.ptp(revolutions)) * len(motion) / (len(motion) - 1))
    if own is None:
        return False
    return own.after > max(NOTICEABLE * _least_clearance(dataset), OWN_SHARE * own.total, LASTING * own.before)


def _steadily_forced(dataset: Signals, within: slice) -> Array | None:
    """Return the motion at bearings (m), shape (n, signals); None if it is too short, or speed or test forces vary."""
    if within.stop - within.start < FEWEST:
        return None
    Omega = _varying_speed(dataset)
    if Omega is not None and np.ptp(Omega[within]) > STEADY_SPEED * np.abs(Omega[within]).max():
        return None
    if _TESTING in dataset and np.ptp(np.asarray(dataset[_TESTING].values)[within]) > 0.0:
        return None
    recorded = [displacements(dataset, f"{bearing}.x", f"{bearing}.y") for bearing in places(dataset).bearings]
    signals = [np.asarray(values, dtype=float)[within] for pair in recorded if pair is not None for values in pair]
    return np.stack(signals, axis=1) if signals else None


def _varying_speed(dataset: Signals) -> Array | None:
    """Return the spin speed (rad/s) at each sample; None if it is constant and was not recorded."""
    return speed(dataset) if speed_changes(dataset) else signal(dataset, "speed")


def _is_noisy(dataset: Signals) -> bool:
    """Return whether the controller's signals have noise."""
    values = parameters(dataset, CONTROLLER)
    preset = values.get("chain.preset")
    return bool(preset) and (preset == RIG or bool(values.get("chain.noise")))


def _at_equal_angles(time: Array, Omega: Array, motion: Array) -> Array:
    """Resample a motion from equal time steps (s) to as many equal steps of shaft angle, given the speed (rad/s)."""
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (np.abs(Omega[1:]) + np.abs(Omega[:-1])) * np.diff(time))])
    if not (np.diff(angle) > 0.0).all():
        return motion
    from scipy.interpolate import CubicSpline  # slow to import

    return np.asarray(CubicSpline(angle, motion)(np.linspace(0.0, angle[-1], len(angle))))


def is_limited(dataset: Signals, within: slice) -> bool:
    """Return whether an axis is at a limit in more than half of the samples; false if an amplifier is faulty."""
    n = within.stop - within.start
    return any(np.count_nonzero(samples) > LIMITED_SHARE * n for samples in _limits(dataset, within))


def _limits(dataset: Signals, within: slice) -> list[Bools]:
    """Return, for each limit of an axis or a demand, which samples reach it; none if an amplifier is faulty."""

    def samples(label: str) -> Bools:
        return np.asarray(dataset[label].values)[within] != 0

    at = places(dataset)
    axes = [f"{ACTUATOR}.{bearing}.{{}}_{axis}" for bearing in at.magnets for axis in at.directions(bearing)]
    faults = [axis.format(fault) for axis in axes for fault in ("amplifier_off", "stuck")]
    never = np.zeros(within.stop - within.start, dtype=bool)
    if any(samples(label).any() for label in faults if label in dataset):
        return [never]
    limits = [axis.format(name) for axis in axes for name in ("clipped", "voltage_limited")]
    limits += [name for name in variables_of(dataset) if name.rpartition(".")[2] in LIMITED]
    return [never, *(samples(label) for label in limits if label in dataset)]


def needed() -> tuple[str, ...]:
    """Return patterns of the variables that are judged besides the displacements at the bearings."""
    names = ("clipped", "voltage_limited", "amplifier_off", "stuck")
    axes, demands = (f"{ACTUATOR}.*.{name}_?" for name in names), (f"*.{name}" for name in LIMITED)
    return (*axes, *demands, _TESTING, f"{PLANT}.speed")


def _least_clearance(dataset: Signals) -> float:
    """Return the smallest clearance of the sites (m); 0 without sites."""
    values = parameters(dataset)
    clearances = (values.get(f"{site}.clearance") for site in places(dataset).sites)
    return min((float(clearance) for clearance in clearances if clearance is not None), default=0.0)
