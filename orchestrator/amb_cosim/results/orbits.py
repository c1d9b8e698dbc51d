"""Orbits at the bearings and in their retainers: largest radius, and synchronous amplitude."""

from __future__ import annotations

import json
from typing import Literal, get_args

import numpy as np

from amb_cosim.cosim.choices import ROLES
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import (
    Path,
    change,
    cycles,
    displacements,
    parameters,
    signal,
    speed,
    thinning,
    turns,
)
from array_types import Array, Bools, Complex

When = Literal["before", "end"]

UPRIGHT = 1e-6  # rad
FALLING = 0.95  # ratio of the largest radii of consecutive cycles, below which a motion is settling
STEADY = 0.1  # change of an ellipse within a turn, over its size, up to which a motion is synchronous
_FEWEST_SAMPLES = 8  # of a turn, for three coefficients
_ENOUGH_SAMPLES = 20  # of a turn, whose largest radius is that of its ellipse within 1.2 %


def path(dataset: Signals, place: str) -> Path | None:
    """Return x and y (m) at a bearing, or at a site relative to the centre of its retainer, shape (2, n).

    If an FMU does not output the displacement at a site, the displacement at the bearing that the retainer protects is
    used. Without such a bearing, the displacement at the site's sensor plane is used.
    """
    rotor_places = places(dataset)
    bearing = rotor_places.retainers.get(place, "")
    at_site = displacements(dataset, f"{place}.x", f"{place}.y")
    if at_site is not None:
        return at_site
    elsewhere = displacements(dataset, f"{bearing}.x", f"{bearing}.y") if bearing else None
    if elsewhere is None and place in rotor_places.measured:
        elsewhere = displacements(dataset, *rotor_places.measured[place])
    return None if elsewhere is None else elsewhere - centre(dataset, place)


def centre(dataset: Signals, site: str) -> Path:
    """Return the centre (m) of a retainer, given by its offset and the motion of its housing, shape (2, n)."""
    values, size = parameters(dataset), dataset.sizes["time"]
    housing = displacements(dataset, f"{site}.housing_x", f"{site}.housing_y")
    offset = np.array([[float(values.get(f"{site}.offset_{axis}") or 0.0)] for axis in "xy"])
    return offset + (np.zeros((2, size)) if housing is None else housing)


def path_at_rest(dataset: Signals, place: str) -> Path | None:
    """Return the displacement (m) at a bearing or a site in the inertial frame, shape (2, n)."""
    motion = path(dataset, place)
    return None if motion is None else motion + centre(dataset, place)


def upright(dataset: Signals) -> complex:
    """Return the complex factor that turns x + j y so that gravity points downwards, as on the live page.

        exp(-j (pi/2 + a)),    a: `gravity_angle`, the direction of gravity from x towards y

    The axes of magnets are often at 45 degrees to the vertical. The factor applies even if the gravity on the rotor is
    left out. It is 1 if no angle is given, and for a vertical shaft, because no direction in its plane of motion is up.
    """
    angle, down = parameters(dataset).get("gravity_angle"), np.sign(gravity_across(dataset) or 1.0)
    if angle is None or is_upright(dataset):
        return 1.0 + 0.0j
    factor = complex(down * np.exp(-1j * (0.5 * np.pi + float(angle))))
    return 1.0 + 0.0j if abs(factor - 1.0) < UPRIGHT else factor


def is_upright(dataset: Signals) -> bool:
    """Return whether the shaft is vertical, according to its tilt or to a stated gravity of 0."""
    if gravity_across(dataset):
        return False
    stated = dataset.attrs.get("scenario_data", "{}")  # JSON, unless the result is only judged
    stated = json.loads(stated) if isinstance(stated, str) else stated
    return "gravity" in stated or bool(parameters(dataset).get("gravity"))


def gravity_across(dataset: Signals) -> float:
    """Return the gravity across the shaft (m/s^2), reduced by the tilt of a shaft that can move along its axis."""
    values = parameters(dataset)
    gravity, tilt = float(values.get("gravity") or 0.0), float(values.get(f"{places(dataset).thrust}.tilt") or 0.0)
    across = gravity * float(np.cos(tilt))
    return across if abs(across) > UPRIGHT * abs(gravity) else 0.0


def turned_upright(dataset: Signals, motion: Path) -> Path:
    """Return the components of a displacement to the right and upwards, shape (2, n); see `upright`."""
    z = upright(dataset) * (motion[0] + 1j * motion[1])
    return np.array([z.real, z.imag])


def directions(dataset: Signals) -> tuple[str, str]:
    """Return the names of the axes of a motion that was `turned_upright`."""
    return ("x", "y") if upright(dataset) == 1.0 else ("to the right", "up")


def radius(dataset: Signals, place: str) -> Array | None:
    """Return the radial displacement (m) at a bearing, or at a site relative to its retainer's centre; see `path`."""
    motion = path(dataset, place)
    return None if motion is None else np.hypot(*motion)


def moving_places(dataset: Signals) -> tuple[str, ...]:
    """Return the bearings, and the retainers that are not in the plane of their bearing."""
    rotor_places = places(dataset)
    return (*rotor_places.bearings, *rotor_places.apart)


def support(dataset: Signals, bearing: str) -> str:
    """Return the place at which the motion in a bearing is judged: its retainer or, if it has none, the bearing."""
    return places(dataset).bearings.get(bearing) or bearing


def orbit_before(dataset: Signals) -> dict[str, float | None]:
    """Return the largest radius (mm) at each of `moving_places` in the cycle before the disturbance, if any."""
    begin, cycle = float(dataset.attrs.get("disturbance_cycle", -np.inf)), cycles(dataset)
    return _largest_radii(dataset, (cycle >= max(begin - 1.0, 0.0)) & (cycle < begin))


def orbit_after(dataset: Signals) -> dict[str, float | None]:
    """Return the largest radius (mm) at each of `moving_places` in the last cycle of the run."""
    cycle = cycles(dataset)
    return _largest_radii(dataset, (cycle >= max(cycle.max(initial=0.0) - 1.0, 0.0)))


def orbit_largest(dataset: Signals) -> dict[str, float | None]:
    """Return the largest radius (mm) at each of `moving_places` from cycle 0 on."""
    return _largest_radii(dataset, cycles(dataset) >= 0.0)


def notices_of_start(dataset: Signals) -> list[str]:
    """Return a sentence if the largest radius at a place belongs to a transient at the start of the run.

        R_k: largest radius in cycle k,    R_(k+1) < 0.95 R_k for k = 0 to n - 1,    R < 0.95 R_0 from cycle n on

    Only cycles before the first event and the first contact are compared, and only if cycle 0 contains enough samples.
    """
    cycle, state = cycles(dataset), signal(dataset, "contact_state")
    events = [float(dataset.attrs.get(f"{role}_cycle", np.inf)) for role in ROLES]
    contact = cycle[(cycle >= 0.0) & (np.asarray(0 if state is None else state) > 0)]
    end = int(min([*events, contact.min(initial=np.inf), cycle.max(initial=0.0)]))
    falling = {}
    for place in moving_places(dataset):
        r = radius(dataset, place)
        if r is None or end < 2 or np.count_nonzero((cycle >= 0.0) & (cycle < 1.0)) < _ENOUGH_SAMPLES:
            continue
        R = np.array([r[(cycle >= k) & (cycle < k + 1)].max(initial=0.0) for k in range(end)])
        n = int(np.argmax(np.append(R[1:] >= FALLING * R[:-1], True)))
        if n > 0 and r[cycle >= n].max() < FALLING * R[0]:
            falling[place] = 100.0 * (1.0 - R[1] / R[0])
    if not falling:
        return []
    falls = ", ".join(f"{name_label(place)} {percent:.2g} %" for place, percent in falling.items())
    return [
        f"the orbit is largest in the transient at the start, and it shrinks by {falls} from the first cycle to the "
        "second; increase settle_cycles"
    ]


def notices_of_samples(dataset: Signals) -> list[str]:
    """Return a sentence if the record is thinned, so that the radii cover only some of the steps.

        1 - |r_n|/max |r| <= 1 - cos(pi/n),    n = 2 pi/(max |Omega| h)                              (1)

    where a turn of a synchronous ellipse contains n >= 3 samples that are h apart.
    """
    every = thinning(dataset)
    if every == 1:
        return []
    h, fastest = every * float(dataset.attrs["communication_step_s"]), float(np.abs(speed(dataset)).max(initial=0.0))
    n = 2.0 * np.pi / (fastest * h) if fastest else np.inf
    missed = f"by up to {100.0 * (1.0 - np.cos(np.pi / n)):.2g} %" if n >= 3.0 else "by much"
    turn = f" ({n:.3g} in a turn)" if np.isfinite(n) else ""
    return [
        f"orbits are sampled only once per {every} steps{turn} and may miss the largest radius of a synchronous "
        f"motion {missed}; record.every = 1 records all steps"
    ]


def settled_amplitudes(dataset: Signals) -> dict[str, dict[str, float | None]]:
    """Return the synchronous amplitude (mm) at each of `moving_places`, `before` the change and at the `end`.

    An amplitude is None if the motion is not synchronous, that is, if the ellipses of the last two revolutions differ
    by more than `STEADY`. A whirl at another frequency leaks into the ellipse of a single revolution.
    """

    def in_mm(place: str, when: When) -> float | None:
        motion = path(dataset, place)
        amplitude = settled_amplitude(dataset, motion, when)
        return None if amplitude is None or not _is_steady(dataset, motion, when) else 1e3 * amplitude

    return {when: {place: in_mm(place, when) for place in moving_places(dataset)} for when in get_args(When)}


def settled_amplitude(dataset: Signals, motion: Path | None, when: When) -> float | None:
    """Return the synchronous amplitude (m) of a displacement, shape (2, n), `before` the change or at the `end`.

    The change is defined in `signal_arrays.change`. The amplitude is that of the last full revolution before the change
    or the end, and None if there is no such revolution.
    """
    circles = _circles(dataset, motion, when)
    return None if circles is None else float(np.abs(circles).sum())


def _is_steady(dataset: Signals, motion: Path | None, when: When) -> bool:
    """Return whether the ellipses of the last two revolutions agree within `STEADY`; also true if one is missing."""
    last, before = (_circles(dataset, motion, when, back) for back in (0.0, 1.0))
    if last is None or before is None:
        return True
    return bool(np.abs(last - before).sum() <= STEADY * np.abs(last).sum())


def _circles(dataset: Signals, motion: Path | None, when: When, back: float = 0.0) -> Complex | None:
    """Return the `synchronous_circles` of the revolution that ends `back` turns before `when`; None if missing."""
    revolutions = turns(dataset)
    at = change(dataset) if when == "before" else np.inf
    if motion is None or at is None or not len(revolutions):
        return None
    end = float(np.interp(at, cycles(dataset), revolutions)) - back
    within = (revolutions > end - 1.0) & (revolutions <= end)
    if end - 1.0 < revolutions[0] or np.count_nonzero(within) < _FEWEST_SAMPLES:
        return None
    x, y = motion[:, within]
    return synchronous_circles(x, y, 2.0 * np.pi * revolutions[within])


def synchronous_circles(x: Array, y: Array, theta: Array) -> Complex:
    """Fit the forward and backward circles, (z_f, z_b), of the ellipse that a point describes in each revolution.

        x + j y ~ z_0 + z_f exp(j theta) + z_b exp(-j theta),       a = abs(z_f) + abs(z_b)

    a is the major semi-axis of the ellipse.

    The three coefficients are fitted by least squares, so a revolution need not be a whole number of samples.

    Parameters
    ----------
    x, y
        Displacement at each sample of a turn, shape (n,), n >= 3 (m).
    theta
        Angle of the rotor at each sample, shape (n,) (rad).
    """
    basis = np.exp(1j * np.outer(theta, [0.0, 1.0, -1.0]))
    (_, forward, backward), *_ = np.linalg.lstsq(basis, x + 1j * y, rcond=None)
    return np.array([forward, backward])


def _largest_radii(dataset: Signals, within: Bools) -> dict[str, float | None]:
    radii = {place: radius(dataset, place) for place in moving_places(dataset)}
    return {p: None if r is None or not within.any() else float(1e3 * r[within].max()) for p, r in radii.items()}
