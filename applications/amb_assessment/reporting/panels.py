"""Plots as data: curves of a run or of a study, thinned for a page."""

from __future__ import annotations

import base64
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.digits import with_micro_signs
from amb_cosim.presentation.units import SIZES, convert_units_in_text, is_place, relabelled
from amb_cosim.results.contact_forces import peaks
from amb_cosim.results.contact_history import ROLLING, rolling_from, touchable
from amb_cosim.results.orbits import directions, path, radius, support, turned_upright
from amb_cosim.results.places import places
from amb_cosim.results.signal_arrays import cycles, parameters, signal, speed, speed_changes
from amb_cosim.results.thinned import judged
from array_types import Array, Bools, Indices

MOST_POINTS = 2400  # of a curve, at most
RPM = 30.0 / np.pi  # 1/min per rad/s


@dataclass(frozen=True)
class Curve:
    """A curve: its name, its points, and its style, which is `lines`, `dots` or `dashed`."""

    name: str
    x: Array
    y: Array
    style: str = "lines"


@dataclass(frozen=True)
class Panel:
    """A plot: title, axis labels, curves, whether both axes have the same scale, and which axes are logarithmic.

    Zones are ranges of y in ascending order, each given by its upper end and its name. The y axis always includes the
    limits in `holds`.
    """

    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    is_round: bool = False
    log: str = ""
    zones: tuple[tuple[float, str], ...] = ()
    holds: tuple[float, ...] = ()

    def as_data(self) -> dict[str, Any]:
        """Return the plot as data for JSON; points are little-endian 32-bit numbers in base64, as in Plotly."""
        finite = [c.y[np.isfinite(c.y)] for c in self.curves]
        return {
            "title": self.title,
            "x": self.x,
            "y": self.y,
            "round": self.is_round,
            "log": self.log,
            "zones": [list(zone) for zone in self.zones],
            "holds": list(self.holds),
            "least": min((float(np.min(y)) for y in finite if len(y)), default=0.0),
            "curves": [{"name": c.name, "style": c.style, "x": _packed(c.x), "y": _packed(c.y)} for c in self.curves],
        }

    def in_chosen_units(self) -> Panel:
        """Return the plot with speeds, lengths and forces in the units that were chosen (`presentation.units`).

        Positions along the shaft keep their unit.
        """
        x, x_factor = (self.x, 1.0) if is_place(self.x) else relabelled(self.x, *SIZES)
        y, y_factor = relabelled(self.y, *SIZES)
        curves = (
            replace(c, name=convert_units_in_text(c.name), x=x_factor * c.x, y=y_factor * c.y) for c in self.curves
        )
        x, y = (with_micro_signs(label) for label in (x, y))
        holds = tuple(y_factor * value for value in self.holds)
        zones = tuple((y_factor * limit, name) for limit, name in self.zones)
        title = convert_units_in_text(self.title)
        return replace(self, title=title, x=x, y=y, curves=tuple(curves), zones=zones, holds=holds)


RunPanels = Callable[[Signals], Iterable[Panel]]
"""Additional plots of a run."""


def panel_of(data: dict[str, Any]) -> Panel:
    """Return the plot that `Panel.as_data` converted to data."""
    curves = (Curve(c["name"], _unpacked(c["x"]), _unpacked(c["y"]), c["style"]) for c in data["curves"])
    zones = tuple((float(limit), str(name)) for limit, name in data.get("zones", ()))
    holds = tuple(map(float, data.get("holds", ())))
    return Panel(data["title"], data["x"], data["y"], tuple(curves), data["round"], data["log"], zones, holds)


def run_panels(run: Signals, others: Iterable[RunPanels] = ()) -> tuple[Panel, ...]:
    """Return the plots of a run: radii, forces, contact state, whirl speeds, the plots of `others`, and orbits."""
    return tuple(_panels(judged(run), others)) if run.sizes["time"] else ()


def horizontal_axis(run: Signals) -> tuple[Array, str, Bools]:
    """Return the values of the horizontal axis from cycle 0 on, the axis label, and the mask of these samples.

    The values are spin speeds (rpm) if the speed changes, and cycles otherwise.
    """
    from_cycle_0 = np.asarray(cycles(run) >= 0.0)
    if speed_changes(run):
        return RPM * speed(run)[from_cycle_0], "spin speed (rpm)", from_cycle_0
    return cycles(run)[from_cycle_0], "cycle", from_cycle_0


def curve(name: str, x: ArrayLike, y: ArrayLike, style: str = "lines") -> Curve:
    """Return a curve; if it has more than `MOST_POINTS` points, keep only the extremes of y in equal parts of it."""
    xs, ys = np.asarray(x, np.float64), np.asarray(y, np.float64)
    if len(xs) > MOST_POINTS:
        extremes = _extremes(ys, MOST_POINTS // 2)
        xs, ys = xs[extremes], ys[extremes]
    return Curve(name, xs, ys, style)


def _panels(run: Signals, others: Iterable[RunPanels]) -> Iterator[Panel]:
    axis, label, from_cycle_0 = horizontal_axis(run)
    bearings = places(run).bearings
    relative = {mb: _relative_radius(run, mb) for mb in bearings}
    yield Panel(
        "Radial displacement over clearance",
        label,
        "radius / clearance",
        tuple(curve(name_label(mb), axis, r[from_cycle_0]) for mb, r in relative.items()),
    )
    forces_of_sites = {site: peaks(run, site) for site in touchable(run)}
    forces = {site: force[from_cycle_0] for site, force in forces_of_sites.items() if force is not None}
    if any(force.any() for force in forces.values()):
        curves = tuple(curve(name_label(site), axis, 1e-3 * force) for site, force in forces.items())
        yield Panel("Normal contact force", label, "N (kN)", curves)
        state = np.asarray(signal(run, "contact_state"))[from_cycle_0]
        meaning = ", ".join(f"{k} {name}" for k, name in enumerate(places(run).contact_states))
        yield Panel(f"Contact state: {meaning}", label, "state", (curve("state", axis, state),))
    modes = [signal(run, f"{site}.mode") for site in forces]
    if any(mode is not None and (mode == ROLLING).any() for mode in modes):
        whirls = {site: signal(run, f"{site}.whirl_speed") for site in forces}  # faces have none
        curves = tuple(
            curve(name_label(site), axis, whirl[from_cycle_0] * RPM)
            for site, whirl in whirls.items()
            if whirl is not None
        )
        yield Panel("Whirl speed", label, "whirl (rpm)", curves)
    for draw in others:
        yield from draw(run)
    if not speed_changes(run):
        title = "Orbits over clearance" + ("" if rolling_from(run) is None else ", until the rotor rolls")
        x, y = (f"{name} / clearance" for name in directions(run))
        yield Panel(title, x, y, tuple(_orbits(run, from_cycle_0)), is_round=True)


def _orbits(run: Signals, inside: Bools) -> Iterator[Curve]:
    """Yield the curves of the clearance and of the orbits.

    If the rotor rolls, the orbits cover the time from just before the disturbance until rolling begins.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    yield Curve("clearance", np.cos(angle), np.sin(angle), "dashed")
    rolling = rolling_from(run)
    if rolling is not None:
        begin = float(run.attrs.get("disturbance_cycle", 0.0)) - 0.5
        inside = inside & (cycles(run) >= begin) & (cycles(run) < rolling + 0.02)
    every = max(1, np.count_nonzero(inside) // (2 * MOST_POINTS))
    for mb, site in places(run).bearings.items():
        orbit = path(run, support(run, mb))
        if orbit is not None:
            x, y = turned_upright(run, orbit[:, inside][:, ::every]) / _clearance(run, site)
            yield Curve(name_label(mb), x, y)


def _relative_radius(run: Signals, bearing: str) -> Array:
    r = radius(run, support(run, bearing))
    assert r is not None  # every run records the bearings
    return np.asarray(r / _clearance(run, places(run).bearings[bearing]))


def _clearance(run: Signals, site: str) -> float:
    return float(parameters(run).get(f"{site}.clearance", 0.75e-3))


def _extremes(values: Array, parts: int) -> Indices:
    """Return the ascending indices of the smallest and the largest value in each of `parts` equal parts."""
    edges = np.linspace(0, len(values), parts + 1).astype(int)
    extremes = {0, len(values) - 1}
    for first, last in pairwise(edges):
        part = values[first:last]
        extremes.update((first + int(np.argmin(part)), first + int(np.argmax(part))))
    return np.array(sorted(extremes), dtype=np.intp)


def _packed(values: Array) -> dict[str, str]:
    return {"dtype": "f4", "bdata": base64.b64encode(np.asarray(values, "<f4").tobytes()).decode("ascii")}


def _unpacked(data: dict[str, str]) -> Array:
    return np.frombuffer(base64.b64decode(data["bdata"]), "<f4").astype(np.float64)
