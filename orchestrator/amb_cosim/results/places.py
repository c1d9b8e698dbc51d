"""The bearings and contact sites of a rotor, as its plant names them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import zip_longest
from typing import Any

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.system.assembly import Assembly
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.results.component_names import PLANT

ATTRIBUTE = "places"  # of a data set


@dataclass(frozen=True)
class RotorPlaces:
    """Bearings and contact sites, in the order of the plant's variables.

    bearings
        Each bearing with its retainer, which is the site where the rotor touches down in that bearing; empty if it has
        none.
    sites
        All contact sites.
    measured
        The names of the displacements x and y of each site that lies in a sensor plane and is not a retainer.
    apart
        The retainers outside the plane of their bearing, where the motion differs.
    valid_to
        Frequency up to which the reduced rotor is accurate (rad/s); None without a limit.
    magnetic
        The bearings that exert a force, including the axial one; the controller and the actuator have no effect on
        others.
    stators
        Each contact site in a stator bore, with the bearing to which that stator belongs.
    second
        Each additional retainer, with its bearing, if `bearings` already contains a retainer of that bearing.
    z
        The position of each site on the shaft (m), if the plant states it.
    faces
        Each face that stops the axial motion of the rotor, with the retainer on which it lands (empty if there is
        none).
    thrust
        The thrust disc of an axial bearing; a rotor with such a disc can move along its shaft. Empty if there is none.
    """

    bearings: Mapping[str, str]
    sites: tuple[str, ...]
    measured: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    apart: tuple[str, ...] = ()
    valid_to: float | None = None
    magnetic: tuple[str, ...] = ()
    stators: Mapping[str, str] = field(default_factory=dict)
    second: Mapping[str, str] = field(default_factory=dict)
    z: Mapping[str, float] = field(default_factory=dict)
    faces: Mapping[str, str] = field(default_factory=dict)
    thrust: str = ""

    @property
    def magnets(self) -> tuple[str, ...]:
        """All bearings that may have magnets: the radial ones, then the axial one, if any."""
        return *self.bearings, *([self.thrust] if self.thrust else [])

    @property
    def magnetic_axes(self) -> tuple[str, ...]:
        """The axes of the magnetic bearings, `BEARING.x`."""
        return tuple(f"{bearing}.{axis}" for bearing in self.magnetic for axis in self.directions(bearing))

    def directions(self, bearing: str) -> str:
        """Return the directions in which a bearing acts: z for the axial bearing, and x and y for all others."""
        return "z" if bearing == self.thrust else "xy"

    @property
    def retainers(self) -> dict[str, str]:
        """Each retainer with the bearing that it protects."""
        return {site: bearing for bearing, site in self.bearings.items() if site}

    @property
    def others(self) -> tuple[str, ...]:
        """The sites other than retainers: bushes, seals, stator bores."""
        return tuple(site for site in self.sites if site not in self.retainers)

    @property
    def contacts(self) -> tuple[str, ...]:
        """All sites and faces."""
        return *self.sites, *self.faces

    @property
    def contact_states(self) -> tuple[str, ...]:
        """The meaning of each value of the plant's `contact_state`: the bearings whose retainers the rotor touches."""
        further = {bearing: [s for s, of in self.second.items() if of == bearing] for bearing in self.bearings}
        sites = ([site or bearing, *further[bearing]] for bearing, site in self.bearings.items())
        names = [" or ".join(map(name_label, of_bearing)) for of_bearing in sites]
        together = ["+".join(n for k, n in enumerate(names) if value >> k & 1) for value in range(2 ** len(names))]
        together[0] = "none"
        return (*together[:3], "both") if len(names) == 2 else tuple(together)

    def to_json(self) -> str:
        """Return the places as the JSON text that `places` reads."""
        return json.dumps(vars(self))


def places(dataset: Signals) -> RotorPlaces:
    """Return the places of the rotor of a data set."""
    stored = dataset.attrs[ATTRIBUTE]  # JSON, unless the result is only judged
    return stored if isinstance(stored, RotorPlaces) else _read(stored)


def limit_of(layout: Mapping[str, Any]) -> float | None:
    """Return the frequency (rad/s) up to which the rotor of an FMU's layout is accurate; None without a limit.

    FMUs of version 0.3 state 0 if there is no limit, and other FMUs do not state any.
    """
    return layout.get("valid_to") or None


@lru_cache(maxsize=8)  # a summary needs them for every signal
def _read(text: str) -> RotorPlaces:
    stored: dict[str, Any] = json.loads(text)
    measured = {site: (x, y) for site, (x, y) in stored.get("measured", {}).items()}
    return RotorPlaces(
        stored["bearings"],
        tuple(stored["sites"]),
        measured,
        tuple(stored.get("apart", ())),
        limit_of(stored),
        tuple(stored.get("magnetic", stored["bearings"])),
        stored.get("stators", {}),
        stored.get("second", {}),
        stored.get("z", {}),
        stored.get("faces", {}),
        stored.get("thrust", ""),
    )


def places_of(assembly: Assembly) -> RotorPlaces:
    """Return the places of a system's plant, read from its FMU's layout or, without one, from its variable names.

    If they are read from the names, the first retainer belongs to the first bearing, and so on. A run without a plant
    has no places.
    """
    if PLANT not in assembly.interfaces:
        return RotorPlaces({}, ())
    result, fed = _named_places(assembly), assembly.system.fed()
    powered = (name for name in result.magnets if f"{PLANT}.{name}.f_{result.directions(name)[0]}" in fed)
    return replace(result, magnetic=tuple(powered))


def _named_places(assembly: Assembly) -> RotorPlaces:
    """Return the places without using the system's connections."""
    fmu, plant = assembly.fmus.get(PLANT), assembly.interfaces[PLANT]
    layout = None if fmu is None else fmu.layout
    if layout is not None:
        retainer_of = {site["bearing"]: site["name"] for site in reversed(layout["sites"]) if site["bearing"]}
        bearings = {bearing: retainer_of.get(bearing, "") for bearing in layout["bearings"]}
        signals = {sensor["name"]: (sensor["x"], sensor["y"]) for sensor in layout["sensors"]}
        others = [site for site in layout["sites"] if site["name"] not in bearings.values()]
        measured = {site["name"]: signals[site["sensor"]] for site in others if site["sensor"]}
        moved_by = layout.get("moved_by", {})
        apart = tuple(site for bearing, site in bearings.items() if site and site not in moved_by.get(bearing, (site,)))
        sites = tuple(site["name"] for site in layout["sites"])
        stators = {site["name"]: site["stator"] for site in layout["sites"] if site.get("stator")}
        second = {site["name"]: site["bearing"] for site in others if site["bearing"]}
        z = {site["name"]: site["z"] for site in layout["sites"] if site.get("z") is not None}
        faces = {face["name"]: face["retainer"] for face in layout.get("faces", ())}
        return RotorPlaces(
            bearings,
            sites,
            measured,
            apart,
            valid_to=limit_of(layout),
            stators=stators,
            second=second,
            z=z,
            faces=faces,
            thrust=layout.get("thrust", ""),
        )
    touching, forces = _parts(plant, "output", "f_n"), _parts(plant, "input", "f_x")
    names = [name for name in _parts(plant, "output", "x") if name in forces]
    return RotorPlaces(dict(zip_longest(names, touching[: len(names)], fillvalue="")), tuple(touching))


def _parts(plant: FmuInterface, causality: str, variable: str) -> list[str]:
    names: Iterable[str] = (port.name for port in plant.of(causality))
    return [name.removesuffix(f".{variable}") for name in names if name.endswith(f".{variable}")]
