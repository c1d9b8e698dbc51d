"""Key values of a run, from the waveforms of its record alone: nothing here calls a function of the product.

`AT_PLACES` and `OF_RUN` have a function for each number of `summary.json`, `OF_RETAINER` and `OF_TOUCHDOWN` for those
of its `touchdown`.
"""

import json
from itertools import groupby

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.signal import welch

FREE, SLIDING, ROLLING = range(3)


class Record:
    """Signals over time, parameters and places of a run, and the summary that the product computed from them."""

    def __init__(self, result):
        data = result.dataset
        self.result, self.given = result, result.summary.as_dict()
        self.signals = {str(name): np.asarray(data[name].values, float) for name in data.data_vars}
        self.attrs = dict(data.attrs)
        self.t, self.T = data["time"].values, float(data.attrs["period_s"])
        self.parameters = {of: dict(values) for of, values in json.loads(data.attrs["parameters"]).items()}
        self.places = json.loads(data.attrs["places"])
        self.cycle, self.h = self.t / self.T, float(np.median(np.diff(self.t)))
        self.after = self.cycle >= -1e-9
        self.of_plant = self.parameters["rotor_contact"]
        self.off = np.array([values for name, values in self.signals.items() if ".amplifier_off_" in name], bool)
        touching = [self[f"{s}.mode"] > 0 for s in self.contacts]
        touching += [self[f"{s}.impulse"] > 0 for s in self.places["sites"]]
        touching += [self[f"{s}.f_n_peak"] > 0 for s in self.contacts]
        self.touching = np.any(touching, axis=0)

    def __getitem__(self, name):
        return self.signals[f"rotor_contact.{name}"]

    def get(self, name):
        return self.signals.get(f"rotor_contact.{name}")

    @property
    def contacts(self):
        return [*self.places["sites"], *self.places["faces"]]

    @property
    def speed(self):
        """The spin speed, measured or prescribed."""
        return self["speed"] if self.of_plant["spin.free"] else self.signals["Omega"]

    @property
    def turns(self):
        whole = np.concatenate([[0.0], np.cumsum(0.5 * (self.speed[1:] + self.speed[:-1]) * np.diff(self.t))])
        return (whole - np.interp(0.0, self.t, whole)) / (2.0 * np.pi)

    @property
    def begin(self):
        return float(self.attrs.get("disturbance_cycle", 0.0))

    @property
    def loaded(self):
        """Which samples end a step between disturbance and relief."""
        end = float(self.attrs.get("relief_cycle", np.inf))
        return (self.cycle > self.begin + 1e-9) & (self.cycle <= end + 1e-9)

    @property
    def release(self):
        """Index of the sample at which power is lost, or contact begins."""
        return int(np.flatnonzero((self.touching | self.off.any(axis=0)) & self.after)[0])

    def motion(self, place):
        """x + j y (m)."""
        return self[f"{place}.x"] + 1j * self[f"{place}.y"]

    def modes(self, site):
        return self[f"{site}.mode"]

    def since_release(self, values):
        return values[self.release :]


def largest(values, within):
    return float(values[within].max()) if within.any() else None


def mean_over_a_millisecond(r, site):
    """The largest of the means over the millisecond before each sample, by the overlap of each step with it."""
    begins, ends, force = r.t[:-1], r.t[1:], r[f"{site}.f_n_mean"][1:]
    found = []
    for k in np.flatnonzero(r.after):
        near = slice(max(k - round(1.2e-3 / r.h) - 2, 0), k)
        overlap = np.minimum(ends[near], r.t[k]) - np.maximum(begins[near], r.t[k] - 1e-3)
        found.append(np.sum(np.maximum(overlap, 0.0) * force[near]) / 1e-3)
    return max(found)


def synchronous(r, place, end, steadiness=0.1):
    """Major semi-axis of the ellipse in the last turn, by Fourier integrals of splines; None if not steady."""
    turns = r.turns
    if np.any(np.diff(turns) <= 0.0):
        return None  # a rotor that stops and rocks has no last turn
    spline = CubicSpline(turns, r.motion(place))

    def circles(last):
        if last - 1.0 < turns[0]:
            return None
        grid = last - 1.0 + (np.arange(2000) + 0.5) / 2000
        return np.array([np.mean(spline(grid) * np.exp(s * 2j * np.pi * grid)) for s in (-1, 1)])

    at, before = circles(end), circles(end - 1.0)
    if at is None or (before is not None and np.abs(at - before).sum() > steadiness * np.abs(at).sum()):
        return None
    return 1e3 * float(np.abs(at).sum())


def share_above(r, site):
    limit, force = r.places["valid_to"], r[f"{site}.f_n"][r.after]
    if limit is None or not force.any():
        return None
    size = min(256, len(force))
    omega, power = welch(force, fs=2.0 * np.pi / r.h, nperseg=size, window="hann", detrend=False, scaling="spectrum")
    return power[omega > limit].sum() / power.sum()


def angle_of_whirl(r, site):
    """The angle (rad) about the centre of a retainer, without jumps."""
    return np.unwrap(np.angle(r.motion(site)))


def whirl_at_the_end(r, site):
    """Mean speed over the last cycle of a contact that lasts through it."""
    if site in r.places["faces"] or r.modes(site)[-1] == FREE:
        return None
    last = (r.cycle > r.cycle[-1] - 1.0) & (r.modes(site) != FREE)
    speeds = np.gradient(angle_of_whirl(r, site), r.t)
    return float(speeds[last].mean())


def blocks(values):
    """Yield each value with its first and last index."""
    at = 0
    for value, group in groupby(values):
        size = len(list(group))
        yield value, at, at + size - 1
        at += size


def rolling(r):
    """First cycle of rolling for a turn of whirl, and for a turn of a race with less whirl."""
    of_whirl, of_race = [], []
    for site in r.places["sites"]:
        angle, race = angle_of_whirl(r, site), r[f"{site}.race_speed"]
        for mode, first, last in blocks(np.where(r.after, r.modes(site), FREE)):
            if mode != ROLLING:
                continue
            turned = np.trapezoid(race[first : last + 1], r.t[first : last + 1])
            if abs(angle[last] - angle[first]) >= 2.0 * np.pi:
                of_whirl.append(r.cycle[first])
            elif abs(turned) >= 2.0 * np.pi:
                of_race.append(r.cycle[first])
    return min(of_whirl, default=None), min(of_race, default=None)


def energy(r):
    """Heat and work since cycle 0, and the largest error of their balance with the stored energy."""
    first = int(np.argmax(r.after))
    since = {
        name: r[f"energy.{name}"] - r[f"energy.{name}"][first] for name in ("damping", "friction", "impact", "work")
    }
    stored = r["energy.kinetic"] + r["energy.strain"]
    error = stored - stored[first] + since["damping"] + since["friction"] + since["impact"] - since["work"]
    found = {name: float(values[-1]) for name, values in since.items()}
    return found | {"balance": float(np.abs(error[first:]).max())}


AT_PLACES = {
    "peak_contact_force_N": lambda r, s: max(largest(r[f"{s}.f_n"], r.after), largest(r[f"{s}.f_n_peak"], r.after)),
    "averaged_contact_force_N": mean_over_a_millisecond,
    "peak_impulse_Ns": lambda r, s: None if s in r.places["faces"] else largest(r[f"{s}.impulse"], r.after),
    "site_share": lambda r, s: float(np.mean(r.modes(s)[r.loaded] != FREE)),
    "whirl_speed_rad_s": whirl_at_the_end,
    "orbit_before_mm": lambda r, s: orbit(r, s, (r.cycle >= max(r.begin - 1.0, 0.0)) & (r.cycle < r.begin)),
    "orbit_after_mm": lambda r, s: orbit(r, s, r.cycle >= r.cycle[-1] - 1.0),
    "orbit_largest_mm": lambda r, s: orbit(r, s, r.after),
    "share_beyond_reduction": share_above,
}


def orbit(r, place, within):
    found = largest(np.abs(r.motion(place)), within)
    return None if found is None else 1e3 * found


def contact_share(r):
    states, counted = r["contact_state"], np.flatnonzero(r.loaded)
    return {str(k): float(np.mean(states[counted] == k)) for k in range(2 ** len(r.places["bearings"]))}


def contact(r, which):
    found = np.flatnonzero(r.touching & r.after)
    return float(r.cycle[found[which]]) if len(found) else None


def settled(r):
    before = float(np.interp(r.begin, r.cycle, r.turns)) if "disturbance_cycle" in r.attrs else None
    at = {"before": before, "end": r.turns[-1]}
    places = [*r.places["bearings"], *r.places["apart"]]
    return {w: {p: None if end is None else synchronous(r, p, end) for p in places} for w, end in at.items()}


def ratio_of_energy(r):
    first = int(np.argmax(r.after))
    names = ("kinetic", "strain", "damping", "friction", "impact", "work")
    series = [r[f"energy.{name}"] - (r[f"energy.{name}"][first] if k > 1 else 0.0) for k, name in enumerate(names)]
    return energy(r)["balance"] / max(np.abs(values[first:]).max() for values in series)


def ratio_of_heat(r):
    of = energy(r)
    heat = abs(of["damping"]) + abs(of["friction"]) + abs(of["impact"])
    return of["balance"] / heat if heat else None


OF_RUN = {
    "simulated_s": lambda r: r.t[-1],
    "cycle_duration_s": lambda r: 2.0 * np.pi / r.speed[np.argmax(r.after)],
    "speed_changes": lambda r: bool(np.ptp(r.speed) > 0.0),
    "first_contact_cycle": lambda r: contact(r, 0),
    "last_contact_cycle": lambda r: contact(r, -1),
    "contact_share": contact_share,
    "rolling_from_cycle": lambda r: rolling(r)[0],
    "rolling_on_race_from_cycle": lambda r: rolling(r)[1],
    "settled_amplitude_mm": settled,
    "energy_J": energy,
    "energy_balance_relative": ratio_of_energy,
    "energy_balance_of_heat": ratio_of_heat,
    "peak_band_rad_s": lambda r: r.places["valid_to"],
}


def durations(r, site, mode):
    """Time in a mode, each step by the mode at its end."""
    steps = np.diff(r.since_release(r.t), prepend=r.t[r.release])
    return float(steps[r.since_release(r.modes(site)) == mode].sum())


def impulse(r, site):
    """Normal impulse from the beginning of the step that ends at the release."""
    first = max(r.release, 1)
    return float(np.sum((r[f"{site}.f_n_mean"] * np.diff(r.t, prepend=r.t[0]))[first:]))


def face_on(r, site):
    return [face for face, retainer in r.places["faces"].items() if retainer == site]


def heat_of(r, site):
    """Heat since the release without that of other faces; a face has the drag of a race that nothing else touches."""
    touched = r.given["touchdown"]["retainers"]
    owner = site if warmed(r, site) in touched else warmed(r, site)
    gained = r[f"{owner}.heat"] - sum(r[f"{face}.heat"] for face in face_on(r, owner) if face != site)
    return float(gained[-1] - gained[r.release])


def warmed(r, site):
    return r.places["faces"].get(site, site)


def temperature(r, site):
    """Largest temperature of one heat capacity, by a separate heat balance C T' = P - h (T - T_ambient)."""
    ring = warmed(r, site)
    C, h = r.of_plant[f"{ring}.heat_capacity"], r.of_plant[f"{ring}.heat_transfer"]
    if not C:
        return None
    power, T = np.diff(r[f"{ring}.heat"]) / np.diff(r.t), [r.of_plant["ambient_temperature"]]
    for k, P in enumerate(power):
        span = (r.t[k], r.t[k + 1])
        after = solve_ivp(lambda t, y, P=P: (P - h * (y - T[0])) / C, span, [T[-1]], rtol=1e-10, atol=1e-12)
        T.append(float(after.y[0, -1]))
    return max(T[r.release :])


def race_spin_up(r, site):
    race = r.get(f"{site}.race_speed")
    if race is None or not r.since_release(race).any():
        return None
    speed, mode, t = (r.since_release(values) for values in (np.abs(race), r.modes(site), r.t))
    up = int(np.flatnonzero(speed >= 0.95 * speed.max())[0])
    return float(t[up] - t[np.flatnonzero(mode != FREE)[0]]) if (mode[up:] == ROLLING).any() else None


def friction_in(r, site):
    """Heat of sliding, mu N |slip| at the end of each step; faces have no such signal."""
    if site in r.places["faces"]:
        return None
    slip, force = (r.since_release(r[f"{site}.{name}"]) for name in ("slip_velocity", "f_n"))
    steps = np.diff(r.since_release(r.t), prepend=r.t[r.release])
    sliding = r.since_release(r.modes(site)) == SLIDING
    return float(np.sum(r.of_plant[f"{site}.mu"] * (force * np.abs(slip) * steps)[sliding]))


def of_most_turning(angles):
    """First and last of the angles whose sum exceeds half their way by most, by trying all."""
    gain = np.concatenate([[0.0], np.cumsum(angles - 0.5 * np.abs(angles))])
    found = [(gain[i + 1 :].max() - gain[i], i) for i in range(len(angles))]
    most, first = max(found, key=lambda of: (of[0], -of[1]))
    return most, first, first + int(np.argmax(gain[first + 1 :]))


def whirl(r, site):
    """Direction, and mean speed weighted by the angle in contact, of the interval with most whirl; flights count pi."""
    if site in r.places["faces"]:
        return None, None
    angle, h = angle_of_whirl(r, site), r.h
    turned = r.since_release(np.diff(angle, prepend=angle[0]))
    turned[0] = 0.0
    touched = np.any([r[f"{site}.{name}"] > 0 for name in ("mode", "impulse", "f_n_peak")], axis=0)
    touched, closed = r.since_release(touched), r.since_release(r.modes(site)) != FREE
    parts = [(k, k) for value, i, j in blocks(touched) if value for k in range(i, j + 1)]
    parts += [(i, j) for value, i, j in blocks(touched) if not value and j + 1 < len(touched)]
    parts.sort()
    angles = np.array([turned[i : j + 1].sum() for i, j in parts])
    angles = np.where([touched[i] for i, _ in parts], angles, np.clip(angles, -np.pi, np.pi))
    for direction, sign in (("backward", -1.0), ("forward", 1.0)):
        most, first, last = of_most_turning(sign * angles)
        within = np.arange(parts[first][0], parts[last][1] + 1)
        within = within[closed[within]]
        way = np.abs(turned[within])
        if most >= np.pi and way.sum() >= 2.0 * np.pi:
            return direction, float(np.average(turned[within] / h, weights=way))
    return "none", None


def standstill(r):
    """First time at which the speed is zero or changes its sign and after which the rotor makes no full turn."""
    speed, t = r.since_release(r.speed), r.since_release(r.t)
    angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(t))])
    for k in np.flatnonzero(speed[1:] * speed[:-1] <= 0.0) + 1:
        if np.ptp(angle[k:]) < 2.0 * np.pi:
            return float(t[k] - t[0])
    return None


def slow(r):
    """Time of the sample after the last at which the rotor turns at more than a hundredth of its speed."""
    speed, t = np.abs(r.since_release(r.speed)), r.since_release(r.t)
    last = int(np.flatnonzero(speed > 0.01 * speed[0])[-1])
    return float(t[last + 1] - t[0]) if last + 1 < len(t) else None


OF_RETAINER = {
    "whirl": lambda r, s: whirl(r, s)[0],
    "whirl_speed_rad_s": lambda r, s: whirl(r, s)[1],
    "free_s": lambda r, s: durations(r, s, FREE),
    "sliding_s": lambda r, s: durations(r, s, SLIDING),
    "rolling_s": lambda r, s: durations(r, s, ROLLING),
    "impulse_Ns": impulse,
    "heat_J": heat_of,
    "temperature_K": temperature,
    "race_spin_up_s": race_spin_up,
    "friction_J": friction_in,
}


def drop(r, place):
    """Largest distance along gravity from the position at the release."""
    g, angle, tilt = (r.of_plant.get(name, 0.0) for name in ("gravity", "gravity_angle", "thrust.tilt"))
    if abs(g * np.cos(tilt)) < 1e-6:
        return None
    along = np.real(np.exp(-1j * angle) * r.since_release(r.motion(place))) * np.sign(g)
    return 1e3 * float(np.max(along - along[0]))


def first_impacts(r):
    steps = r.since_release(r.t) - r.t[r.release]
    found, total = [], sum(r.since_release(r[f"{s}.impulse"]).sum() for s in r.places["sites"])
    for site in r.places["sites"]:
        p, mode = r.since_release(r[f"{site}.impulse"]), r.since_release(r.modes(site))
        for k in np.flatnonzero(p > 0.0):
            if mode[k] == FREE or k == 0 or mode[k - 1] == FREE or p[k] >= 1e-6 * total:
                found.append((steps[k], site, p[k]))
    order = {site: k for k, site in enumerate(r.contacts)}
    found.sort(key=lambda hit: (hit[0], order[hit[1]], 0.0))
    return [{"site": site, "after_s": float(at), "impulse_Ns": float(p)} for at, site, p in found[:5]]


def free_after(r):
    """Time of the sample after the last contact, if there is none in the last tenth of the time."""
    t, touching = r.since_release(r.t) - r.t[r.release], r.since_release(r.touching)
    return None if touching[t >= 0.9 * t[-1]].any() else float(t[np.flatnonzero(touching)[-1] + 1])


OF_TOUCHDOWN = {
    "standstill_after_s": standstill,
    "slow_after_s": slow,
    "free_after_s": free_after,
    "release_s": lambda r: float(r.t[r.release]),
    "first_impacts": first_impacts,
    "drop_mm": lambda r: {p: drop(r, p) for p in [*r.places["bearings"], *r.places["apart"]]},
    "orbit_mm": lambda r: {
        p: 1e3 * float(np.abs(r.since_release(r.motion(p))).max()) for p in [*r.places["bearings"], *r.places["apart"]]
    },
}
