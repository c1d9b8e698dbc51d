"""Parameters and inputs on which the plant's outputs initially depend (`plant.initialise`), for the variable table.

A modelDescription declares them as InitialUnknowns, which importers use to solve for start values. A missing dependency
is an error; an unnecessary one only costs time.

If the rotor starts at rest in the centre, only quantities relative to the retainers have dependencies. If the rotor
starts on its orbit, it is deflected by steady loads and whirls due to unbalance; each journal that is beyond its
clearance is moved back individually. Contact forces then depend on everything that accelerates the rotor, including
magnetic bearing forces.
"""

from __future__ import annotations

from collections.abc import Iterable

from rotor_contact.variables.planes import Planes

SUPPORT = ("initial.orbit", "Omega", "bearings[*].k_b")
WHIRL = (*SUPPORT, "initial.angle", "bearings[*].c_b", "discs[*].u", "discs[*].phi", "cores[*].u", "cores[*].phi")
GRAVITY = ("gravity", "gravity_angle")
PUT_BACK = ("enabled", "clearance", "offset_x", "offset_y")  # of a site
CONTACT = ("law", "mu", "mu_static", "stribeck_velocity", "journal_radius", "housing_mass")  # of a site
FREE_SPIN = ("spin.free", "spin.inertia", "spin.drag", "drive.torque", "drive.torque_limit", "drive.ideal")
MAGNETS = ("axes[*].force", "axes[*].gradient", "axes[*].reference")

ALWAYS_SAME = {"initially_depends_on": ()}  # options of an output that has the same value at every start


def _loads(axes: str) -> tuple[str, ...]:
    """Return the loads that deflect the rotor in these axes."""
    return (*GRAVITY, *(f"base.a_{axis}" for axis in axes), *(f"discs[*].f_{axis}" for axis in axes))


ORBIT = (*WHIRL, *_loads("xy"))


def _put_back(sites: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"{site}.{name}" for site in sites for name in PUT_BACK)


def displacement(planes: Planes, place: str, axis: str) -> tuple[str, ...]:
    """Return the dependencies of the displacement at a bearing or a sensor plane.

    Without contact, the whirl couples the axes, and so does rotating damping if the shaft has any.
    """
    sites = planes.moved_by.get(place, ())
    return (*WHIRL, *_loads("xy" if sites or planes.mixes_axes else axis), *_put_back(sites))


def journal(planes: Planes, site: str) -> tuple[str, ...]:
    """Return the dependencies of the position and velocity of the journal at a site."""
    return (*ORBIT, *_put_back(planes.moved_by.get(site, (site,))))


def strain(planes: Planes) -> tuple[str, ...]:
    """Return the dependencies of the deflection of the whole rotor."""
    return (*ORBIT, *(f"sites[*].{name}" for name in PUT_BACK))


def motion(planes: Planes) -> tuple[str, ...]:
    """Return the dependencies of the rotor's kinetic energy: only those of the whirl, unless a journal is moved back.

    On a circular orbit this energy is the same at every angle.
    """
    if planes.sites or planes.seals:
        return strain(planes) if planes.sites else WHIRL
    return tuple(name for name in WHIRL if name != "initial.angle")


def slip(planes: Planes, site: str) -> tuple[str, ...]:
    """Return the dependencies of the slip velocity at a site; a journal that is moved back keeps this velocity."""
    others = [other for other in planes.moved_by.get(site, ()) if other != site]
    own = (f"{site}.offset_x", f"{site}.offset_y", f"{site}.journal_radius")
    return (*ORBIT, *own, *_put_back(others))


def sliding(planes: Planes) -> tuple[str, ...]:
    """Return the dependencies of the forces of sliding contacts, on which rotating retainer parts have no effect."""
    return (*strain(planes), *(f"sites[*].{name}" for name in CONTACT), *FREE_SPIN, *MAGNETS)


def sliding_contact(planes: Planes) -> tuple[str, ...]:
    """Return the dependencies of a whirling journal's contact state; with a single site they exclude friction."""
    return sliding(planes) if len(planes.sites) > 1 else (*strain(planes), "sites[*].law", *FREE_SPIN, *MAGNETS)


def forces(planes: Planes) -> tuple[str, ...]:
    """Return the dependencies of the contact forces; race inertias matter if contacts roll (no spin, no whirl)."""
    return (*sliding(planes), "sites[*].race_inertia")
