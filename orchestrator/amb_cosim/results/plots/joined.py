"""The line that joins the samples of an orbit: an arc in contact, no line where samples are too far apart."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.contact_history import FREE
from amb_cosim.results.signal_arrays import signal
from array_types import Array, Bools

ARC = math.radians(5.0)  # between the points of an arc
APART = math.radians(45.0)  # between samples without contact, from which on nothing joins them
OUTSIDE = 0.5  # of the clearance; within it a path may pass the centre, so that angles mean nothing
TURN = math.radians(60.0)  # at a sample in flight
SHORT, BOUNCES = 0.03, 0.9  # of the clearance: chords that cannot mislead, and from where on a turn is a bounce


def orbit_line(dataset: Signals, site: str, path: Array, clearance: float) -> tuple[Array, NDArray[np.int64]]:
    """Return the `joined` line of a path about a site's centre, in any orientation; without a site, the path itself."""
    if not site:
        return path, np.arange(path.shape[1])
    touching = signal(dataset, f"{site}.mode")
    whirl = signal(dataset, f"{site}.whirl_speed")
    turned = None if whirl is None else 0.5 * (whirl[1:] + whirl[:-1]) * np.diff(dataset["time"].values)
    closed = np.zeros(path.shape[1], bool) if touching is None else touching != FREE
    return joined(path, closed, clearance, turned)


def dots_sample() -> Line2D:
    """Return the entry of a legend for the dots of `draw_joined`."""
    return Line2D([], [], color="0.3", marker=".", ms=2.5, ls="", label="samples too far apart to join")


def draw_joined(panel: Axes, x: Array, y: Array, **style: Any) -> bool:
    """Draw a `joined` line, with dots for isolated samples; return whether there are any dots."""
    panel.plot(x, y, **style)
    apart = np.isnan(np.concatenate([[np.nan], x, [np.nan]]))
    alone = apart[:-2] & apart[2:] & ~apart[1:-1]
    if alone.any():
        panel.plot(x[alone], y[alone], ".", ms=2.5, mew=0.0, color=style["color"], alpha=style.get("alpha"))
    return bool(alone.any())


def joined(
    path: Array, touching: Bools, clearance: float, turned: Array | None = None
) -> tuple[Array, NDArray[np.int64]]:
    """Return a path with points between its samples, and the sample that each point follows.

    A rotor that touches at two successive samples stays on its retainer between them, so an arc joins these samples.
    The angle of the arc is the one nearest to `turned`. A chord would show the rotor in the middle of the clearance,
    where it never was. Two other successive samples are separated by NaN if both are beyond `OUTSIDE` and their angles
    differ by more than `APART`, because the path between them is unknown. Samples of a flight at which the path turns
    by more than `TURN` are also separated by NaN. The rotor then vibrates faster than it is sampled, so chords would
    look like bounces.

    Parameters
    ----------
    path
        Displacement x and y from the centre of the retainer, shape (2, n).
    touching
        Whether each sample is in contact, shape (n,).
    clearance
        Clearance of the retainer, in the unit of the path.
    turned
        Angle (rad) of whirl from each sample to the next, if known, shape (n - 1,); without it, the shorter arcs are
        drawn.

    Returns
    -------
    path, sample
        Shapes (2, m) and (m,), m >= n.
    """
    if path.shape[1] < 2:
        return path, np.arange(path.shape[1])
    r, phi = np.hypot(*path), np.arctan2(path[1], path[0])
    step = (np.diff(phi) + np.pi) % (2.0 * np.pi) - np.pi
    in_contact = touching[:-1] & touching[1:]
    if turned is not None:
        known = np.where(in_contact & np.isfinite(turned), turned, step)
        step = step + 2.0 * np.pi * np.round((known - step) / (2.0 * np.pi))
    outside = (r[:-1] > OUTSIDE * clearance) & (r[1:] > OUTSIDE * clearance)
    is_gap = ~in_contact & (outside & (np.abs(step) > APART) | _vibrates(path, touching, clearance))
    finite = np.nan_to_num(np.minimum(np.abs(step), 2.0 * np.pi))  # a whole turn covers its circle
    parts = np.where(in_contact, np.maximum(np.ceil(finite / ARC), 1.0), np.where(is_gap, 2.0, 1.0)).astype(np.int64)
    sample = np.append(np.repeat(np.arange(len(parts)), parts), len(parts))
    number = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
    share = np.append(number / np.repeat(parts, parts), 0.0)
    following = np.minimum(sample + 1, len(parts))
    radius = r[sample] + share * (r[following] - r[sample])
    angle = phi[sample] + share * np.append(step, 0.0)[sample]
    between = share > 0.0
    result = np.where(between, [radius * np.cos(angle), radius * np.sin(angle)], path[:, sample])
    result[:, between & np.append(is_gap, False)[sample]] = np.nan
    return result, sample


def _vibrates(path: Array, touching: Bools, clearance: float) -> Bools:
    """Return which chords meet at an angle above `TURN` at a sample in flight; `SHORT` chords do not count."""
    place = path[0] + 1j * path[1]
    chord = np.diff(place)
    is_long = np.abs(chord) > SHORT * clearance
    turn = np.abs(np.angle(chord[1:] * np.conj(chord[:-1])))
    flies = ~touching[1:-1] & (np.abs(place[1:-1]) < BOUNCES * clearance)
    sharp = is_long[1:] & is_long[:-1] & flies & (turn > TURN)
    return np.append(sharp, False) | np.append(False, sharp)
