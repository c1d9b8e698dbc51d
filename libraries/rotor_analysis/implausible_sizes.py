"""Detection of implausible sizes and materials of a rotor, whose likely cause is a wrong unit in the rotor file."""

from __future__ import annotations

import math

from rotor_analysis.rotor import Rotor

LONGEST, SHORTEST = 40.0, 3e-3  # m, of a shaft; a dental turbine has 10 to 20 mm, a steam turbine and generator 15 m
THICKEST = 3.0  # m, diameter of a shaft
WIDEST = 4.0  # m, radius of a disc
HEAVIEST = 3e5  # kg; the rotor of a nuclear power station's generator has 250 t
LARGEST = 0.5  # m, distance of a centre of mass from its seat on a shaft that is shorter
LOOSEST = 0.02  # m, radial clearance
SOFTEST = 1e9  # Pa, Young's modulus of the stiffest material; a polyamide has 3e9 Pa
LIGHTEST, MASSLESS = 100.0, 0.5  # kg/m3, of the densest material; less stands for a shaft without mass


def implausible_sizes(rotor: Rotor) -> tuple[str, ...]:
    """Return a sentence for each kind of size that is implausible: lengths, masses, inertias, materials.

    A disc with the mass and polar inertia of a body has the radius r; a rod with the mass and diametral inertia of the
    body has the length l:

        r = sqrt(2 I_p/m),   l = sqrt(12 I_d/m)                                                            (1)
    """
    nodes = rotor.shaft.nodes
    length = nodes[-1] - nodes[0]
    layers = [layer for element in rotor.elements for layer in element]
    thickest = max(d for layer in layers for d in layer.diameter)
    stiffest = max(layer.material.youngs_modulus for layer in layers)
    densest = max(layer.material.density for layer in layers)
    lengths = [
        _above("length of the shaft", length, LONGEST, "m"),
        _above("diameter of the shaft", thickest, THICKEST, "m"),
        *(_above(f"clearance of {site.name}", site.clearance, LOOSEST, "m") for site in rotor.sites),
        *(_above(f"clearance of {face.name}", face.clearance, LOOSEST, "m") for face in rotor.faces),
        *(_above(f"offset of {body.name}", abs(body.offset), max(length, LARGEST), "m") for body in rotor.bodies),
    ]
    masses = [_above("mass", rotor.mass, HEAVIEST, "kg")]
    inertias = []
    for body in (body for body in rotor.bodies if body.mass > 0.0):
        radius, rod = (math.sqrt(a / body.mass) for a in (2.0 * body.polar_inertia, 12.0 * body.diametral_inertia))
        of = f"with the mass and inertia of {body.name}"
        inertias.append(_above(f"radius of a disc {of}", radius, WIDEST, "m"))
        inertias.append(_above(f"length of a rod {of}", rod, LONGEST, "m"))
    small = _below("length of the shaft", length, SHORTEST, "m")
    soft = _below("largest youngs_modulus", stiffest, SOFTEST, "Pa")
    light = _below("largest density", densest, LIGHTEST, "kg/m3") if densest >= MASSLESS else ""
    kinds = (
        (lengths, "lengths are in m; are the lengths in its file in mm?"),
        (masses, "masses are in kg, and follow from lengths in m; is its file in g or mm?"),
        (inertias, "inertias are in kg m2 and radii in m; is its file in kg mm2 or mm?"),
        ([small], "lengths are in m; were the lengths in its file converted to m twice?"),
        ([soft], "moduli are in Pa; are the moduli in its file in GPa or N/mm2?"),
        ([light], "densities are in kg/m3; are the densities in its file in g/cm3?"),
    )
    found = ((", ".join(filter(None, parts)), cause) for parts, cause in kinds)
    return tuple(f"rotor {rotor.name} has implausible sizes: {parts}; {cause}" for parts, cause in found if parts)


def _above(what: str, value: float, limit: float, unit: str) -> str:
    return f"{what} = {value:.4g} {unit} (plausible: <= {limit:g} {unit})" if value > limit else ""


def _below(what: str, value: float, limit: float, unit: str) -> str:
    return f"{what} = {value:.4g} {unit} (plausible: >= {limit:g} {unit})" if value < limit else ""
