"""Converts a rotor saved by ROSS (`ross_elements`) to the content of a rotor file."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

from amb_files.toml import validate
from rotor_analysis.ross_elements import SavedRotor, read_saved
from rotor_analysis.ross_magnets import SavedMagnet, magnet_of
from rotor_analysis.ross_parts import AXES, DRAWING, SavedBearing, SavedMaterial, SavedShaftElement
from rotor_analysis.ross_tables import beyond_saved, sampled
from rotor_analysis.rotor import Rotor


class ImportedRotor(NamedTuple):
    """The content of a rotor file, notes on the differences from ROSS, and a mapping of names to magnetic bearings."""

    content: dict[str, Any]
    notes: list[str]
    magnets: dict[str, SavedMagnet]


def read_ross(path: Path, frequency: float | None = None) -> ImportedRotor:
    """Return a rotor saved by ROSS as the content of a rotor file.

    Its discs are planes of unbalance, and its sensors are those of the magnetic bearings; it has no contact sites.

    Parameters
    ----------
    path
        The file.
    frequency
        Whirl frequency (rad/s) at which frequency-dependent coefficients are evaluated, because a rotor file contains
        coefficients only as functions of speed. By default the coefficients of magnetic bearings are evaluated at the
        lowest frequency of their tables.

    Raises
    ------
    ValueError
        If the file cannot be read, is not a ROSS file, or has features that a rotor file cannot describe; the message
        lists them.
    """
    saved, name = read_saved(path, frequency), _names()
    bodies: list[dict[str, Any]] = [
        {
            "name": name(disk.tag),
            "node": disk.n + 1,
            "mass": disk.m,
            "diametral_inertia": disk.Id,
            "polar_inertia": disk.Ip,
            "unbalance": True,
        }
        for disk in saved.disks
    ]
    bodies += [
        {"name": name(mass.tag), "node": mass.n + 1, "mass": mass.mx, "diametral_inertia": 0.0, "polar_inertia": 0.0}
        for mass in saved.masses
    ]
    bearings, seals = (
        [{"name": name(b.tag), "node": b.n + 1} | _coefficients(b, frequency) for b in supports]
        for supports in (saved.bearings, saved.seals)
    )
    magnet_or_none = [magnet_of(bearing) for bearing in saved.bearings]
    magnets = {str(b["name"]): magnet for b, magnet in zip(bearings, magnet_or_none, strict=True) if magnet is not None}
    sensors = [{"name": f"{bearing}_probe", "node": magnet.sensor_node + 1} for bearing, magnet in magnets.items()]
    content = {"name": saved.title} | _shaft(saved.elements) | _damping(saved.elements[0])
    content |= {"bodies": bodies, "bearings": bearings}
    content |= {key: parts for key, parts in (("seals", seals), ("sensors", sensors)) if parts}
    validate(content, Rotor, f"ROSS file {path}")
    return ImportedRotor(content, list(dict.fromkeys(_notes(saved, frequency))), magnets)


def _notes(saved: SavedRotor, frequency: float | None) -> Iterator[str]:
    first = saved.elements[0]
    if first.shear_effects and first.shear_method_calc == "hutchinson":
        yield "The shear coefficient is Hutchinson's; the one in ROSS lacks a factor 1 + nu."
    for bearing in (*saved.bearings, *saved.seals):
        if any((*bearing.kzz, *bearing.czz, *bearing.mzz)):
            yield f"{bearing.tag}: its axial coefficients are omitted."
        if bearing.frequency:
            omega, is_magnet = _frozen_at(bearing, frequency), magnet_of(bearing) is not None
            value = f"{omega:.6g} rad/s ({omega / math.tau:.4g} Hz)"
            yield (
                f"{bearing.tag}: its coefficients are those at the whirl frequency {value}; modes at other "
                f"frequencies are less accurate."
            )
            if is_magnet:
                yield (
                    "Coefficients of magnets are used only in analyses without a controller; poles and runs use the "
                    "scenario's magnets."
                )
                yield from _non_collocated(bearing)
        if len(bearing.speed or ()) > 3 and bearing.interpolation == "spline":
            yield "Coefficients over speed follow ROSS's spline, which smooths the saved values."
        yield from beyond_saved(bearing)
        others = sorted(set(bearing.model_extra or {}) - DRAWING)
        if others and magnet_of(bearing) is None:
            yield f"{bearing.tag}: only its stiffness, damping and mass are imported, not {', '.join(others)}."


def _non_collocated(bearing: SavedBearing) -> Iterator[str]:
    """Yield a note on a magnet whose sensors are at another node; ROSS feeds back the motion at the magnet instead."""
    magnet = magnet_of(bearing)
    if magnet is not None and magnet.sensor_node != bearing.n:
        yield (
            f"{bearing.tag}: its sensors are at node {magnet.sensor_node + 1}, its magnet is at node {bearing.n + 1}; "
            "ROSS feeds back the motion at the magnet, so the modes of ROSS differ from the poles of the scenario."
        )


def _names() -> Callable[[str], str]:
    """Return a function that converts tags to unique names of letters, digits and underscores."""
    taken: set[str] = set()

    def name(tag: str) -> str:
        plain = re.sub(r"[^A-Za-z0-9]+", "_", tag).strip("_").lower()
        plain = plain if plain[:1].isalpha() else f"part_{plain}"
        candidates = (plain if k == 1 else f"{plain}_{k}" for k in range(1, len(taken) + 2))
        chosen = next(candidate for candidate in candidates if candidate not in taken)
        taken.add(chosen)
        return chosen

    return name


def _shaft(elements: list[SavedShaftElement]) -> dict[str, Any]:
    """Return the tables `shaft` and `materials`; the first element at a node is the shaft, and others are sleeves."""
    first: dict[int, SavedShaftElement] = {}
    for element in elements:
        first.setdefault(element.n, element)
    base = [first[n] for n in sorted(first)]
    nodes = [round(z, 12) for z in accumulate((element.L for element in base), initial=0.0)]
    materials, name_of = _materials(elements)
    shaft: dict[str, Any] = {
        "nodes": nodes,
        "theory": "timoshenko" if base[0].shear_effects else "rayleigh",
        "mass_matrix": "consistent",
        "diameter": _collapsed([element.odl for element in base]),
        "inner_diameter": _collapsed([element.idl for element in base]),
        "material": _collapsed([name_of(element.material) for element in base]),
    }
    if any((element.odl, element.idl) != (element.odr, element.idr) for element in base):
        shaft["diameter_end"] = _collapsed([element.odr for element in base])
        shaft["inner_diameter_end"] = _collapsed([element.idr for element in base])
    if base[0].shear_method_calc != "cowper":
        shaft["shear"] = base[0].shear_method_calc
    sleeves = [
        {
            "begin": nodes[element.n],
            "end": nodes[element.n + 1],
            "diameter": element.odl,
            "inner_diameter": element.idl,
            "diameter_end": element.odr,
            "inner_diameter_end": element.idr,
            "material": name_of(element.material),
        }
        for element in elements
        if element is not first[element.n]
    ]
    return {"shaft": shaft | ({"sleeves": sleeves} if sleeves else {}), "materials": materials}


def _damping(element: SavedShaftElement) -> dict[str, Any]:
    """Return the table `damping`, or no table if there is no damping; ROSS defines damping in the fixed frame."""
    values = {"mass": element.alpha, "stiffness": element.beta}
    return {"damping": values | {"rotating": 0.0}} if any(values.values()) else {}


def _materials(elements: list[SavedShaftElement]) -> tuple[dict[str, Any], Callable[[SavedMaterial], str]]:
    """Return the table `materials`, and a function that returns a material's name in it."""
    name, names = _names(), dict[str, str]()
    table: dict[str, Any] = {}
    for material in (element.material for element in elements):
        if material.model_dump_json() not in names:
            names[material.model_dump_json()] = chosen = name(material.name)
            nu = material.E / (2.0 * material.G_s) - 1.0
            table[chosen] = {"youngs_modulus": material.E, "density": material.rho, "poissons_ratio": nu}
    return table, lambda material: names[material.model_dump_json()]


def _collapsed(values: list[Any]) -> Any:
    """Return a single value if all are equal, and otherwise the list."""
    return values[0] if len(set(values)) == 1 else values


def _coefficients(bearing: SavedBearing, frequency: float | None) -> dict[str, Any]:
    """Return the stiffness, the damping and any mass of a bearing, at one or several speeds."""
    if bearing.frequency:
        omega = _frozen_at(bearing, frequency)
        return _tensors(_frozen(bearing, omega))[0] | {"whirl_frequency": f"{float(omega)!r} rad/s"}
    if len(bearing.speed or ()) < 2:
        return _tensors(bearing)[0]
    bearing = sampled(bearing) if bearing.interpolation == "spline" else bearing
    return {
        "at_speed": [
            {"speed": f"{float(speed)!r} rad/s"} | row
            for speed, row in zip(bearing.speed or (), _tensors(bearing), strict=True)
        ]
    }


def _frozen_at(bearing: SavedBearing, frequency: float | None) -> float:
    """Return the whirl frequency (rad/s) at which coefficients are evaluated; by default the lowest in the table."""
    return (bearing.frequency or [0.0])[0] if frequency is None else frequency


def _frozen(bearing: SavedBearing, frequency: float) -> SavedBearing:
    """Return the bearing with coefficients interpolated at a whirl frequency (rad/s) by monotone cubics, as in ROSS.

    Raises
    ------
    ValueError
        If the frequency is outside the bearing's table.
    """
    from scipy.interpolate import PchipInterpolator  # slow to import

    table = bearing.frequency or []
    if not table[0] <= frequency <= table[-1]:
        span = f"{table[0]:.6g} to {table[-1]:.6g} rad/s"
        raise ValueError(f"frequency = {frequency:.6g} rad/s is not allowed; {bearing.tag} has values from {span}")
    names = [f"{letter}{axes}" for letter in "kcm" for axes in AXES]
    curves = {name: values for name in names if (values := getattr(bearing, name))}
    if len(table) > 1:
        curves = {name: [float(PchipInterpolator(table, values)(frequency))] for name, values in curves.items()}
    return bearing.model_copy(update={"frequency": None, **curves})


def _tensors(bearing: SavedBearing) -> list[dict[str, Any]]:
    """Return the stiffness, the damping and any mass as [[xx, xy], [yx, yy]] at each speed."""
    count = len(bearing.speed or [0.0])
    rows: list[dict[str, Any]] = [{} for _ in range(count)]
    for key, letter in (("stiffness", "k"), ("damping", "c"), ("mass", "m")):
        curves = [getattr(bearing, f"{letter}{axes}") or [0.0] * count for axes in AXES]
        if letter != "m" or any(map(any, curves)):
            for row, (xx, xy, yx, yy) in zip(rows, zip(*curves, strict=True), strict=True):
                row[key] = [[xx, xy], [yx, yy]]
    return rows
