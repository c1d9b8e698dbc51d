"""The plant of a rotor: its variables, and the matrices of the reduced rotor in a single flat array."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from amb_cosim.model_constants.stator_names import stator_site
from array_types import Array
from fmi_export.model import Model
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.implausible_sizes import implausible_sizes
from rotor_analysis.inertia import MASSLESS
from rotor_analysis.pairs import times_turned
from rotor_analysis.parts import Bearing, Site
from rotor_analysis.receptance_error import receptance_error
from rotor_analysis.reduced_rotor import reduced_rotor, valid_to
from rotor_analysis.reduction import Reduction
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.plant import model_for
from rotor_contact.shaft.seals import SEAL, SealRecords, Seals, add_seals
from rotor_contact.shaft.structure import FACE_PLACE, SIZES, Structure
from rotor_contact.variables.planes import ContactSite, Face, MeasuredPlane, Planes

MAX_SUBSTEP = 250e-6  # s, longest substep of a rotor without fast modes
RESOLUTION = 1.0  # rad of the fastest mode per substep
ROUNDING = 1e-9  # relative contribution of a site to the displacement of a place that counts as zero


def plant(rotor: Rotor | None = None, stators: Sequence[str] = ()) -> tuple[Model, Array]:
    """Return the plant of a rotor, by default the packs' default rotor, and the constants of the plant.

    The layout of the plant contains the `mass` (kg) in addition to the planes.

    Parameters
    ----------
    rotor
        A rotor description.
    stators
        Names of bearings that get a contact site in their stator bore (`stator_bores`).

    Raises
    ------
    ValueError
        If the rotor has no bearing, cannot be reduced as its file requires (`reduced_rotor`), or has seals with a mass
        that the plant does not support (`constant_mass`). The errors of `stator_bores` are also raised.
    """
    rotor = rotor or load_rotor()
    structure, planes = plant_structure(rotor, stators)
    model = model_for(planes)
    return replace(model, layout={**model.layout, "mass": rotor.mass}), flat_constants(structure)


def stator_bores(rotor: Rotor, bearings: Sequence[str]) -> tuple[Site, ...]:
    """Return the stator bores of bearings as contact sites, except bores that the rotor itself declares.

    The sites lie in the planes of the bearings. Every reduction retains the motion of these planes, so the sites do not
    change the reduction.

    Raises
    ------
    ValueError
        If another part of the rotor already uses the name of such a site.
    """
    declared = {site.stator for site in rotor.sites}
    nodes = {bearing.name: bearing.node for bearing in rotor.bearings}
    bores = [Site(stator_site(name), nodes[name], stator=name) for name in bearings if name not in declared]
    for site in bores:
        if site.name in rotor.nodes_by_name:
            raise ValueError(
                f"the name {site.name!r} of a part of rotor {rotor.name!r} is not allowed here, because the stator "
                f"bore of {site.stator} has this name"
            )
    return tuple(bores)


def plant_structure(
    rotor: Rotor, stators: Sequence[str] = (), reduction: Reduction | None = None
) -> tuple[Structure, Planes]:
    """Return the data of a rotor for the plant's kernels, and the planes under their names in the rotor file.

    The rotor is reduced as in its file (`reduced_rotor`), unless another `reduction` is set.

    The moments of a seal become a separate seal, NAME.tilt, whose x and y are the slopes of its node
    (`Bearing.tilting`). The start value of the longest substep is short enough for the fastest mode of the free rotor.
    Bearings among `stators` get a contact site in their stator bore.

    Raises
    ------
    ValueError
        As for `plant`.
    """
    if not rotor.bearings:
        raise ValueError(f"rotor {rotor.name!r} has no bearings; a plant needs at least one")
    full = assemble(rotor)
    _require_mass(rotor, full)
    reduction = reduction or reduced_rotor(rotor)
    reduced = reduction.model.viscous()
    order = reduced.translations_first
    place = {row: k for k, row in enumerate(order)}
    at, left, right = np.ix_(order, order), reduction.left[order], reduction.right[:, order]
    M, C, R, K, G = (matrix[at] for matrix in (reduced.M, reduced.C, reduced.R, reduced.K, reduced.G))
    tilting = [seal.tilting for seal in rotor.seals if seal.tilting is not None]
    at_seals = full.rows(rotor.seal_nodes) + [row + 2 for row in full.rows(tuple(part.node for part in tilting))]
    for k, seal in enumerate(rotor.seals):
        at_seal = at_seals[2 * k : 2 * k + 2]
        M += left[:, at_seal] @ constant_mass(seal) @ right[at_seal]
    if rotor.seals and not np.linalg.eigvalsh(M)[0] > 0.0:
        what = "with the mass of its seals, the mass matrix must be positive definite"
        raise ValueError(f"rotor {rotor.name!r} is not allowed; {what}")
    Minv: Array = np.linalg.inv(M).astype(np.float64)
    seals = Seals(
        seal_records((*rotor.seals, *tilting)), np.concatenate([right[at_seals], (Minv @ left[:, at_seals]).T])
    )

    def first_rows(nodes: tuple[int, ...]) -> Array:
        return np.array([place[reduced.translations[node][0]] for node in nodes], dtype=np.float64)

    sites = (*rotor.sites, *stator_bores(rotor, stators))
    site_names = [site.name for site in sites]
    centre = rigid_body(rotor).centre
    places = np.array(
        [
            (
                1.0 if face.stops == "-z" else -1.0,
                rotor.shaft.nodes[face.node - 1] - centre,
                site_names.index(face.retainer) if face.retainer else -1,
            )
            for face in rotor.faces
        ],
        dtype=FACE_PLACE,
    )
    at_faces = [row + k for row in full.rows(tuple(face.node for face in rotor.faces))[::2] for k in range(4)]
    face_rows = np.concatenate(
        [right[at_faces].reshape(-1, 4, len(M)), (Minv @ left[:, at_faces]).T.reshape(-1, 4, len(M))], 1
    )
    number = {bearing.name: k for k, bearing in enumerate(rotor.bearings)}
    structure = Structure(
        n_translations=2 * len(reduced.translations),
        is_damped=bool(np.any(C) or np.any(R) or rotor.seals),
        valid_to=valid_to(full, reduced) or _accurate_to(rotor),
        n_thrust=1 if rotor.thrust else 0,
        mass=rotor.mass,
        n_faces=len(rotor.faces),
        forms=np.concatenate([M, C, R]),
        K=K,
        Minv=Minv,
        MinvK=Minv @ K,
        MinvC=Minv @ (C + R),
        over_speed=np.concatenate([Minv @ G, times_turned(Minv @ R)]),
        B_disc=full.at_points(left.T, rotor.disc_points),
        B_base=-(left @ full.M @ full.base_motion).T,
        sensors=right[full.rows(rotor.sensor_nodes)],
        bearings=first_rows(rotor.bearing_nodes),
        sites=first_rows(tuple(site.node for site in sites)),
        site_bearings=np.array([number.get(site.bearing or "", -1) for site in sites], dtype=np.float64),
        seals=seals,
        faces=np.concatenate([places.view(np.float64), face_rows.ravel()]),
    )
    max_substep = RESOLUTION / max(_fastest(structure), RESOLUTION / MAX_SUBSTEP)  # a rigid rotor has no fast mode
    planes = replace(
        _planes(rotor, sites),
        max_substep=max_substep,
        polar_inertia=rigid_body(rotor).polar_inertia,
        valid_to=structure.valid_to,
        mixes_axes=bool(np.any(R) or np.any(seals.records["coefficients"][..., 4:12])),  # of the stiffness over x and y
    )
    return structure, replace(planes, moved_by=_moved_by(planes, structure))


def _require_mass(rotor: Rotor, full: Matrices) -> None:
    """Raise ValueError if a node has no mass, because it would move instantly when the force on it changes."""
    least = MASSLESS * rotor.mass
    light = [node for node, (x, _) in full.translations.items() if full.M[x, x] <= least]
    if light:
        density = min(layer.material.density for layers in rotor.elements for layer in layers)
        what = (
            f"nodes {light} of rotor {rotor.name!r} have no mass; the density must be > 0 kg/m3 in a plant, such "
            f"as 1 kg/m3"
        )
        raise ValueError(f"shaft.density = {density:g} kg/m3 is not allowed; {what}")


def _accurate_to(rotor: Rotor) -> float:
    """Return the frequency (rad/s) up to which the receptance of the plant's model is accurate; infinite if unlimited.

    A stiff rotor may have no elastic mode within the band of its reduction, although the reduction represents the rotor
    at frequencies below its first mode.
    """
    error = receptance_error(rotor)
    return math.inf if error is None else error.limit


def _moved_by(planes: Planes, structure: Structure) -> dict[str, tuple[str, ...]]:
    """Return the sites whose displacements contribute to the displacement of each site, bearing and sensor."""
    rows = dict(zip((site.name for site in planes.sites), structure.sites.astype(int), strict=True))
    unit = np.eye(len(structure.K))
    weights = {name: unit[row] for name, row in rows.items()}
    weights |= {name: unit[int(row)] for name, row in zip(planes.bearings, structure.bearings, strict=True)}
    weights |= {sensor.name: structure.sensors[2 * k] for k, sensor in enumerate(planes.sensors)}
    return {
        place: tuple(site for site, row in rows.items() if abs(weight[row]) > ROUNDING)
        for place, weight in weights.items()
    }


def _fastest(structure: Structure) -> float:
    """Return the largest eigenvalue magnitude (rad/s) of the rotor on its seals alone, without gyroscopic forces."""
    if not structure.is_damped:
        return float(np.sqrt(np.max(np.abs(np.linalg.eigvals(structure.MinvK)))))
    identity, zero = np.eye(len(structure.K)), np.zeros_like(structure.K)
    largest = 0.0
    for Omega in {0.0, *structure.seals.records["begin"].ravel().tolist()}:
        K, C = structure.MinvK.T.copy(), structure.MinvC.T.copy()
        add_seals(structure.seals, Omega, K, C)
        A = np.block([[zero, identity], [-K.T, -C.T]])
        largest = max(largest, float(np.max(np.abs(np.linalg.eigvals(A)))))
    return largest


def _planes(rotor: Rotor, sites: Sequence[Site]) -> Planes:
    sensors = {sensor.node: sensor.name for sensor in reversed(rotor.sensors)}
    return Planes(
        discs=tuple(body.name for body in rotor.discs),
        bearings=tuple(bearing.name for bearing in rotor.bearings),
        sites=tuple(
            ContactSite(
                s.name,
                s.clearance,
                _shaft_radius(rotor, s.node) if s.journal_radius is None else s.journal_radius,
                s.bearing or "",
                sensors.get(s.node, ""),
                s.stator or "",
                float(rotor.shaft.nodes[s.node - 1]),
            )
            for s in sites
        ),
        sensors=tuple(MeasuredPlane(s.name, s.x, s.y) for s in rotor.sensors),
        seals=(*(s.name for s in rotor.seals), *(f"{s.name}.tilt" for s in rotor.seals if s.tilting is not None)),
        thrust=rotor.thrust,
        faces=tuple(Face(f.name, f.clearance, f.radius, f.retainer or "") for f in rotor.faces),
        loss_factor=rotor.damping.loss_factor,
        implausible=implausible_sizes(rotor),
    )


def _shaft_radius(rotor: Rotor, node: int) -> float:
    """Return the larger of the shaft radii (m) on the two sides of a node."""
    before, after = rotor.elements[: node - 1][-1:], rotor.elements[node - 1 : node]
    diameters = [layer.diameter[1] for layers in before for layer in layers]
    diameters += [layer.diameter[0] for layers in after for layer in layers]
    return max(diameters) / 2.0


def flat_constants(structure: Structure) -> Array:
    """Return a structure in the layout of `rotor_contact.shaft.structure.structure_of`."""
    n_translations, is_damped, valid_to, n_thrust, mass, n_faces, *arrays, seals, faces = structure
    sizes = np.array(
        [
            (
                len(structure.K),
                n_translations,
                len(structure.B_disc) // 2,
                len(structure.bearings),
                len(structure.sites),
                len(structure.sensors),
                is_damped,
                valid_to,
                seals.records.shape[1],
                seals.records.shape[0],
                n_thrust,
                mass,
                n_faces,
            )
        ],
        dtype=SIZES,
    )
    return np.concatenate(
        [sizes.view(np.float64), *(np.ravel(part).view(np.float64) for part in (*arrays, *seals, faces))]
    )


def constant_mass(seal: Bearing) -> Array:
    """Return the mass (kg) of a seal for the plant, shape (2, 2).

    Raises
    ------
    ValueError
        If the mass depends on the speed, or is not symmetric.
    """
    masses = [np.array(row.mass) for row in seal.at_speed] or [np.array(seal.mass)]
    if any(not np.array_equal(mass, masses[0]) for mass in masses):
        raise ValueError(f"speed-dependent mass of seal {seal.name} is not allowed in the plant; it must be constant")
    if masses[0][0, 1] != masses[0][1, 0]:
        text = masses[0].tolist()
        raise ValueError(f"mass of seal {seal.name} = {text} kg is not allowed in the plant; it must be symmetric")
    return masses[0]


def seal_records(seals: Sequence[Bearing]) -> SealRecords:
    """Return a record of each seal for each range between the speeds in the seals' tables."""
    speeds = sorted({row.speed for seal in seals for row in seal.at_speed})
    records = np.zeros((len(speeds) + 1 if seals else 0, len(seals)), dtype=SEAL)
    for k, seal in enumerate(seals):
        of_seal = records[:, k]
        table_speeds = [row.speed for row in seal.at_speed]
        of_seal["begin"] = [speeds[0] if speeds else 0.0, *speeds]
        of_seal["lowest"], of_seal["highest"] = min(table_speeds, default=-np.inf), max(table_speeds, default=np.inf)
        cubics = of_seal["coefficients"].reshape(len(of_seal), 8, 4)
        for place, begin in enumerate(of_seal["begin"]):
            if place and table_speeds and table_speeds[0] <= begin < table_speeds[-1]:
                interpolant = seal.interpolant()
                for power in range(4):
                    cubics[place, :, power] = interpolant(begin, nu=power)[:2].ravel() / math.factorial(power)
            else:
                cubics[place, :, 0] = np.ravel(seal.at(begin if place else -np.inf)[:2])
        of_seal["coefficients"] = cubics.reshape(len(of_seal), 32)
    return records.view(np.recarray)
