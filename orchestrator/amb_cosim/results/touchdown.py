"""Touchdown: fall, whirl and rest of a rotor on its retainers, computed from a data set.

Every value is None if the data set lacks the required variables. Times start at the release.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from amb_cosim.cosim.record.signals import Samples, Signals, SignalTable, variables_of
from amb_cosim.results.contact_forces import received_impulse, touches
from amb_cosim.results.contact_history import FREE, ROLLING, in_contact, touchable
from amb_cosim.results.orbits import gravity_across, moving_places, path, path_at_rest, radius
from amb_cosim.results.places import places
from amb_cosim.results.power import amplifiers_off, power_lost_at
from amb_cosim.results.rocking import pendulum_period, steady_swing
from amb_cosim.results.signal_arrays import Path, at_every_step, cycles, parameters, signal, speed
from array_types import Array, Bools, Indices

SLIDING = 1
N_IMPACTS = 5
SPUN_UP = 0.95  # of a race's largest speed
AT_REST = 0.05  # of the clearance; smaller motion counts as rest
SLOW = 0.01  # of the speed at release
LAST_PART = 0.1  # of the time from release on, in which the rotor must be at rest
REST_PERIODS = 2.0  # of a swing in the retainer, in which it must be at rest too
WHIRL_TURNS = 10.0  # net backward turns from which a landing whirls; of 512 landings, 172 did with 2 and 168 with 20
WHIRLS = 1.0  # turns net of going to and fro, and turns in contact, below which a motion is not a whirl
LEAST_IMPACT = 1e-6  # of the sum of all impacts; less is rounding where a contact lasts

Direction = Literal["forward", "backward", "none"]


@dataclass(frozen=True)
class Impact:
    """A step with impacts at a site."""

    site: str
    after: Annotated[float, "s"]
    impulse: Annotated[float, "N.s"]


@dataclass(frozen=True)
class Retainer:
    """Loads and motion of a contact site.

    Attributes
    ----------
    free, sliding, rolling
        Total time after the release in each mode of contact (s).
    whirl
        `backward` if the rotor whirled backward about the site at any time, by at least `WHIRLS` (see `_most_turning`);
        otherwise `forward` if it whirled forward by as much, and `none` if it did neither.
    whirl_speed
        Mean whirl speed in contact during that whirl (rad/s), negative for backward whirl. The average is weighted by
        the angle of whirl, so that times at rest do not count.
    impulse
        Sum of the impulses of impacts and of the time integral of the normal force (N s).
    friction
        Heat of sliding friction in contact (J), computed from samples of the friction power.
    heat
        Heat of friction, race drag and impacts (J), excluding the heat of faces on this retainer. The drag of a race
        that the rotor touches only at a face is included at that face.
    race_spin_up
        Time from the first contact until the race turns at 95 % of its largest speed (s); None if the race does not
        turn, or if the rotor still slides on it.
    temperature
        Largest temperature (K); None if the retainer has no heat capacity.
    """

    free: Annotated[float | None, "s"]
    sliding: Annotated[float | None, "s"]
    rolling: Annotated[float | None, "s"]
    whirl: Direction | None
    whirl_speed: Annotated[float | None, "rad/s"]
    impulse: Annotated[float | None, "N.s"]
    friction: Annotated[float | None, "J"]
    heat: Annotated[float | None, "J"]
    race_spin_up: Annotated[float | None, "s"]
    temperature: Annotated[float | None, "K"]


@dataclass(frozen=True)
class Touchdown:
    """A fall onto the retainers, or the contact of an upright rotor whose magnets are switched off.

    Attributes
    ----------
    release
        Time at which the first amplifier switches off, or contact begins (s from cycle 0).
    drop
        Largest fall (mm) along gravity from the position at the release, at each bearing and at each retainer that is
        not in the plane of its bearing; None if there is no gravity across the shaft.
    orbit
        Largest radius at the same places from the release on (mm).
    first_impacts
        The first five steps with impacts. If the site is free before or after the step, every impact counts, however
        small. In a contact that lasts, only impacts of at least a millionth of the sum of all impacts count.
    retainers
        Loads and motion at each touched site.
    rest_after
        Time (s) after which the rotor lies in contact and stays where it is at the end, to within 5 % of the clearance
        of each retainer and of each touched site or face. It must stay there for the last tenth of the time and for two
        periods of a swing in the retainer with the largest clearance, since a pendulum seems to rest where it turns.
    rocks_within
        Largest swing (deg) at all touched sites if the rotor rocks steadily (see `rocking`); None if it rests or moves
        otherwise.
    free_after
        Time of the last contact of a rotor that is free for the last tenth of the time (s).
    standstill_after
        Time at which the spin ends (s): the speed is 0 or reverses, and the rotor makes no full turn afterwards.
    slow_after
        Time after which the rotor turns at less than 1 % of its speed at the release (s).
    """

    release: Annotated[float, "s"]
    drop: Annotated[dict[str, float | None], "mm"]
    orbit: Annotated[dict[str, float | None], "mm"]
    first_impacts: tuple[Impact, ...]
    retainers: dict[str, Retainer]
    rest_after: Annotated[float | None, "s"]
    rocks_within: Annotated[float | None, "deg"]
    free_after: Annotated[float | None, "s"]
    standstill_after: Annotated[float | None, "s"]
    slow_after: Annotated[float | None, "s"]

    @property
    def whirls_backward_at(self) -> list[str]:
        """The touched sites at which the rotor has whirled backward."""
        return [site for site, item in self.retainers.items() if item.whirl == "backward"]


def landing_whirl(dataset: Signals) -> tuple[float, bool] | None:
    """Return the whirl number of a landing, and whether it is decided that the landing whirls or does not.

    The whirl number is the largest number of net backward turns about a site in any interval since the power loss,

        W = max_i max_[a, b] (sum(-dpsi_i) - sum(|dpsi_i|)/2) / pi                                            (2)

    where dpsi_i is the angle of whirl in a step of contact or in a flight. A longer run never has a smaller one. A
    landing whirls from `WHIRL_TURNS` on. That it does not whirl is decided when the races of all touched sites turn at
    95 % of the rotor's speed or more, so that friction has ended, and W has not grown for 10 turns of the rotor; or
    when the rotor is at rest. The result is None unless all magnets lose their power.
    """
    steps, lost = at_every_step(dataset), power_lost_at(at_every_step(dataset))
    if lost is None:
        return None
    after = _from(steps, int(np.searchsorted(cycles(steps), lost)))
    turned = np.abs(np.cumsum(speed(after) * _steps(after))) / (2.0 * np.pi)
    recent = int(np.searchsorted(turned, turned[-1] - WHIRL_TURNS))
    number, grows = 0.0, turned[-1] < WHIRL_TURNS
    touched = [site for site in touchable(dataset) if touches(after, site).any()]
    for site in touched:
        whirl = signal(after, f"{site}.whirl_speed")
        if whirl is None:
            return None
        angles, begins = _turned(after, site, whirl)
        number = max(number, _most_turning(-angles)[0] / np.pi)
        grows |= _most_turning(-angles[begins < recent])[0] < _most_turning(-angles)[0]
    if number >= WHIRL_TURNS:
        return number, True
    races = [signal(after, f"{site}.race_speed") for site in touched]
    spun_up = all(race is not None and abs(race[-1]) >= SPUN_UP * abs(speed(after)[-1]) for race in races)
    if touched and spun_up and not grows:
        return number, True
    fall = touchdown(dataset)
    return number, fall is not None and (fall.rest_after is not None or fall.standstill_after is not None)


def touchdown(dataset: Signals) -> Touchdown | None:
    """Describe the touchdown of a run.

    The result is None if there is no contact, or if there is no gravity and no amplifier is off.
    """
    steps, values = at_every_step(dataset), parameters(dataset)
    contact, from_cycle_0 = in_contact(steps), cycles(steps) >= 0.0
    if contact is None or not (contact & from_cycle_0).any():
        return None
    if not values.get("gravity") and not any((off & from_cycle_0).any() for off in amplifiers_off(steps)):
        return None
    released = np.any([contact, *amplifiers_off(steps)], axis=0) & from_cycle_0
    release_step = int(np.argmax(released))
    release = float(steps["time"].values[release_step])
    start = int(np.searchsorted(dataset["time"].values[:-1], release))
    lying = contact[np.searchsorted(steps["time"].values, dataset["time"].values[start:])]
    after, sampled = _from(steps, release_step), _from(dataset, start)
    impulses = {site: _impulse(steps, site, release_step) for site in places(dataset).contacts}
    touched = [site for site in touchable(dataset) if touches(after, site).any()]
    heights = {place: height(sampled, place) for place in moving_places(dataset)}
    radii = {place: radius(sampled, place) for place in moving_places(dataset)}
    across = [site for site in touched if site not in places(dataset).faces]
    rest = _rest(sampled, lying, touched)
    return Touchdown(
        release=release,
        drop={place: None if at is None else 1e3 * float(at[0] - at.min()) for place, at in heights.items()},
        orbit={place: None if r is None else 1e3 * float(r.max()) for place, r in radii.items()},
        first_impacts=_first_impacts(after, list(impulses)),
        retainers={site: _retainer(after, site, impulses[site], touched) for site in touched},
        rest_after=rest,
        rocks_within=None if rest is not None else _rocks(sampled, lying, across),
        free_after=_free(after, contact[release_step:]),
        standstill_after=_standstill(after),
        slow_after=_slow(after),
    )


def _from(dataset: Signals, start: int) -> Signals:
    """Return the data set from the sample of the release on."""
    variables = {name: Samples(dataset[name].values[start:], dataset[name].attrs) for name in variables_of(dataset)}
    coordinates = {name: Samples(dataset[name].values[start:], {}) for name in ("time", "cycle")}
    return SignalTable(variables, coordinates, dataset.attrs)


def _times(after: Signals) -> Array:
    """Return the times from the release on (s)."""
    times = after["time"].values
    return np.asarray(times - times[0], np.float64)


def _steps(after: Signals) -> Array:
    """Return the time step (s) of each sample from the release on; each sample is at the end of its step."""
    return np.diff(_times(after), prepend=0.0)


def height(dataset: Signals, place: str) -> Array | None:
    """Return the height (m) of the rotor, measured against gravity, above the centre at a bearing or site.

    The result is None if there is no gravity across the shaft.
    """
    return _upwards(dataset, path_at_rest(dataset, place))


def height_in_retainer(dataset: Signals, place: str) -> Array | None:
    """Return the height (m) of the rotor above the centre of a retainer, which has an offset and moves on its mount.

    The result is None if there is no gravity across the shaft. At the bottom of the retainer it is minus the clearance.
    """
    return _upwards(dataset, path(dataset, place))


def _upwards(dataset: Signals, motion: Path | None) -> Array | None:
    """Return the component of a displacement (m) against gravity, if there is gravity across the shaft."""
    values, gravity = parameters(dataset), gravity_across(dataset)
    if motion is None or "gravity_angle" not in values or not gravity:
        return None
    angle = values["gravity_angle"]
    return np.asarray(-np.sign(gravity) * (np.array([np.cos(angle), np.sin(angle)]) @ motion), np.float64)


def _first_impacts(after: Signals, sites: Sequence[str]) -> tuple[Impact, ...]:
    """Return the first impacts; sustained contact has impacts due to rounding, which are left out."""
    times, impacts = _times(after), list[Impact]()
    recorded = [(site, values) for site in sites if (values := signal(after, f"{site}.impulse")) is not None]
    least = LEAST_IMPACT * sum(float(impulse.sum()) for _, impulse in recorded)
    for site, impulse in recorded:
        mode = signal(after, f"{site}.mode")
        free = np.zeros(len(times), dtype=bool) if mode is None else mode == FREE
        begins_or_ends = free | np.append(True, free[:-1])
        counted = (impulse > 0.0) & (begins_or_ends | (impulse >= least))
        impacts += [Impact(site, float(times[k]), float(impulse[k])) for k in np.flatnonzero(counted)]
    return tuple(sorted(impacts, key=lambda impact: impact.after)[:N_IMPACTS])


def _retainer(after: Signals, site: str, impulse: float | None, touched: Sequence[str]) -> Retainer:
    """Return the loads of one of the touched sites from the release on."""
    mode, power = (signal(after, f"{site}.{name}") for name in ("mode", "friction_power"))
    faces = places(after).faces
    warmed = faces.get(site, site)
    temperature = signal(after, f"{warmed}.temperature")
    owner = site if warmed in touched else warmed  # books the drag of its race, whichever face turns it
    heat = signal(after, f"{owner}.heat")
    for face, retainer in faces.items():
        on_face = signal(after, f"{face}.heat")
        if retainer == owner and face != site and heat is not None and on_face is not None:
            heat = heat - on_face
    durations = _steps(after)
    free, sliding, rolling = (
        None if mode is None else float(durations[mode == value].sum()) for value in (FREE, SLIDING, ROLLING)
    )
    direction, whirl_speed = _whirl(after, site)
    warms = temperature is not None and bool(parameters(after).get(f"{warmed}.heat_capacity"))
    return Retainer(
        free=free,
        sliding=sliding,
        rolling=rolling,
        whirl=direction,
        whirl_speed=whirl_speed,
        impulse=impulse,
        friction=None if power is None else float(np.sum(power * durations)),
        heat=None if heat is None else float(heat[-1] - heat[0]),
        race_spin_up=_race_spin_up(after, site),
        temperature=float(temperature.max()) if warms and temperature is not None else None,
    )


def _whirl(after: Signals, site: str) -> tuple[Direction | None, float | None]:
    """Return the direction of the rotor's whirl about a site (backward takes precedence), and its mean speed (rad/s).

    A flight between contacts counts as half a turn at most, because a levitated rotor that orbits without contact, or
    passes the centre, does not whirl about a retainer.
    """
    mode, whirl = (signal(after, f"{site}.{name}") for name in ("mode", "whirl_speed"))
    if mode is None or whirl is None:
        return None, None
    turned, (angles, begins) = whirl * _steps(after), _turned(after, site, whirl)
    if not len(angles):
        return "none", None
    directions: tuple[tuple[Direction, float], ...] = (("backward", -1.0), ("forward", 1.0))
    for direction, sign in directions:
        turning, first, last = _most_turning(sign * angles)
        within = slice(begins[first], begins[last] + 1)
        in_contact = np.abs(turned[within]) * (mode[within] != FREE)
        if turning >= WHIRLS * np.pi and in_contact.sum() >= WHIRLS * 2.0 * np.pi:
            return direction, float(np.average(whirl[within], weights=in_contact))
    return "none", None


def _turned(after: Signals, site: str, whirl: Array) -> tuple[Array, Indices]:
    """Return the angles (rad) of whirl in each step of contact and in each flight, and the samples of their begin."""
    touched = touches(after, site)
    if not touched.any():
        return np.empty(0), np.empty(0, np.intp)
    end = np.flatnonzero(touched)[-1] + 1
    begins = np.flatnonzero(touched[:end] | np.append(False, touched[: end - 1]))
    angles = np.add.reduceat((whirl * _steps(after))[:end], begins)
    flying = ~touched[begins]
    angles[flying] = np.clip(angles[flying], -np.pi, np.pi)
    return angles, begins


def _most_turning(angles: Array) -> tuple[float, int, int]:
    """Return the largest value (rad) of (1) for any interval of angles, and the interval's first and last index.

        sum(angles) - sum(|angles|)/2                                                                 (1)

    For a motion in one direction, (1) is half the angle. For a motion whose net angle is half of its total angle, (1)
    is 0. If (1) is at least pi, the net angle is at least a turn. The largest value never decreases if angles are
    appended.
    """
    total = np.append(0.0, np.cumsum(angles - 0.5 * np.abs(angles)))
    gained = total - np.minimum.accumulate(total)
    last = int(np.argmax(gained))
    return float(gained[last]), int(np.argmin(total[: last + 1])), max(last - 1, 0)


def _impulse(steps: Signals, site: str, start: int) -> float | None:
    accumulated = received_impulse(steps, site)
    return None if accumulated is None else float(accumulated[-1] - accumulated[max(start - 1, 0)])


def _race_spin_up(after: Signals, site: str) -> float | None:
    race, mode = (signal(after, f"{site}.{name}") for name in ("race_speed", "mode"))
    if race is None or mode is None or not race.any() or not (mode != FREE).any():
        return None
    times, speed = _times(after), np.abs(race)
    n = int(np.argmax(speed >= SPUN_UP * speed.max()))
    if not (mode[n:] == ROLLING).any():  # a race on which the rotor still slides is not up to speed
        return None
    return float(times[n] - times[np.argmax(mode != FREE)])


def _lying(after: Signals, contact: Bools, sites: Iterable[str]) -> list[tuple[Path, float]]:
    """Return position (or gap, at faces) and clearance at each site, if there is contact in the last part of the run.

    The list is empty if there is no such contact, as in levitation, or if a position was not recorded.
    """
    values = parameters(after)
    recorded = [(_position(after, site), values.get(f"{site}.clearance")) for site in sites]
    lying = [(positions, float(c)) for positions, c in recorded if positions is not None and c is not None]
    return lying if contact[_last_part(after)].any() and len(lying) == len(recorded) else []


def _position(after: Signals, site: str) -> Path | None:
    if site not in places(after).faces:
        return path(after, site)
    gap = signal(after, f"{site}.gap")
    return None if gap is None else gap[np.newaxis, :]


def _rest(after: Signals, contact: Bools, touched: Sequence[str]) -> float | None:
    """Return the time after which the rotor stays in place in its retainers and at everything that it touches."""
    last, lying = _last_part(after), _lying(after, contact, dict.fromkeys([*places(after).retainers, *touched]))
    moving = np.zeros(len(last), bool)
    for positions, clearance in lying:
        for position in positions:
            moving |= np.abs(position - position[last].mean()) > AT_REST * clearance
    if not lying or moving[last].any():
        return None
    times, rest, gravity = _times(after), _time_after(_times(after), moving), gravity_across(after)
    swing = max(pendulum_period(clearance, gravity) for _, clearance in lying) if gravity else 0.0
    return rest if times[-1] - rest >= REST_PERIODS * swing else None


def _rocks(after: Signals, contact: Bools, touched: Sequence[str]) -> float | None:
    """Return the largest swing (deg) if the rotor rocks steadily at all touched sites and touches at the end."""
    gravity, swings = gravity_across(after), list[float]()
    for positions, clearance in _lying(after, contact, touched):
        swing = steady_swing(_times(after), positions[0] + 1j * positions[1], clearance, gravity)
        if swing is None:
            return None
        swings.append(swing)
    return float(np.degrees(max(swings))) if swings else None


def _free(after: Signals, contact: Bools) -> float | None:
    """Return the time of the last contact of a rotor that has none in the last part of the run."""
    return None if contact[_last_part(after)].any() else _time_after(_times(after), contact)


def _last_part(after: Signals) -> Bools:
    """Return which samples from the release on are in the last part of the run."""
    times = _times(after)
    return np.asarray(times >= (1.0 - LAST_PART) * times[-1])


def _standstill(after: Signals) -> float | None:
    """Return the time at which the speed is 0 or reverses and after which the rotor makes no full turn.

    A rotor that sticks to its retainers still rocks, and its speed changes sign, whereas a rotor that rolls keeps
    turning.
    """
    speed = signal(after, "speed")
    if speed is None or not speed[0]:
        return None if speed is None else 0.0
    times = _times(after)
    turned = np.append(0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times)))
    highest, lowest = (of.accumulate(turned[::-1])[::-1] for of in (np.maximum, np.minimum))
    stops = np.append(False, (speed[1:] == 0.0) | (speed[1:] * speed[:-1] < 0.0))
    ends = np.flatnonzero(stops & (highest - lowest < 2.0 * np.pi))
    return float(times[ends[0]]) if len(ends) else None


def _slow(after: Signals) -> float | None:
    speed = signal(after, "speed")
    if speed is None:
        return None
    turning = np.abs(speed) > SLOW * abs(speed[0])
    return None if turning[-1] else _time_after(_times(after), turning)


def _time_after(times: Array, active: Bools) -> float:
    """Return the time of the sample after the last active one; 0 if there is none."""
    return float(times[np.flatnonzero(active)[-1] + 1]) if active.any() else 0.0
