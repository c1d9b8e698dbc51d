"""What the plant's outputs depend on at the start (`plant.initialise`), for `starts_from` of the variable table.

At rest in the centre nothing does but what is measured from the retainers. On its orbit the rotor has the deflection by
the steady loads and the whirl by unbalance; journals beyond their clearance are put back onto it, each for itself.
Contact forces then follow from all that accelerates the rotor, the forces of the magnetic bearings included.
"""

from __future__ import annotations

from collections.abc import Iterable

from rotor_contact.planes import Planes

SUPPORT = ("initial.orbit", "Omega", "bearings[*].k_b")
WHIRL = (*SUPPORT, "bearings[*].c_b", "discs[*].u", "discs[*].phi", "cores[*].u", "cores[*].phi")
GRAVITY = ("gravity", "gravity_angle")
PUT_BACK = ("enabled", "clearance", "offset_x", "offset_y")  # of a site
CONTACT = ("law", "mu", "mu_static", "stribeck_velocity", "journal_radius", "housing_mass")  # of a site
FREE_SPIN = ("spin.free", "spin.inertia", "spin.drag", "drive.torque", "drive.torque_limit")
MAGNETS = ("axes[*].force", "axes[*].gradient", "axes[*].reference")


def _loads(axes: str) -> tuple[str, ...]:
    """Return the loads that deflect the rotor in these axes."""
    return (*GRAVITY, *(f"base.a_{axis}" for axis in axes), *(f"discs[*].f_{axis}" for axis in axes))


ORBIT = (*WHIRL, *_loads("xy"))


def _put_back(sites: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"{site}.{name}" for site in sites for name in PUT_BACK)


def displacement(planes: Planes, place: str, axis: str) -> tuple[str, ...]:
    """What the displacement at a bearing or a sensor plane depends on.

    Without contact there the axes are coupled by the whirl alone, unless the shaft has damping that rotates.
    """
    sites = planes.moved_by.get(place, ())
    return (*WHIRL, *_loads("xy" if sites or planes.mixes_axes else axis), *_put_back(sites))


def journal(planes: Planes, site: str) -> tuple[str, ...]:
    """What position and velocity of the journal at a site depend on."""
    return (*ORBIT, *_put_back(planes.moved_by.get(site, (site,))))


def strain(planes: Planes) -> tuple[str, ...]:
    """What the deflection of the whole rotor depends on."""
    return (*ORBIT, *(f"sites[*].{name}" for name in PUT_BACK))


def motion(planes: Planes) -> tuple[str, ...]:
    """What the velocities of the whole rotor depend on: they are the whirl's but where a journal is put back."""
    return strain(planes) if planes.sites else WHIRL


def slip(planes: Planes, site: str) -> tuple[str, ...]:
    """What the slip velocity at a site depends on: put back, its own journal keeps it."""
    others = [other for other in planes.moved_by.get(site, ()) if other != site]
    own = (f"{site}.offset_x", f"{site}.offset_y", f"{site}.journal_radius")
    return (*ORBIT, *own, *_put_back(others))


def sliding(planes: Planes) -> tuple[str, ...]:
    """What the forces depend on of contacts that slide; what turns in a retainer then does not count."""
    return (*strain(planes), *(f"sites[*].{name}" for name in CONTACT), *FREE_SPIN, *MAGNETS)


def sliding_contact(planes: Planes) -> tuple[str, ...]:
    """What it depends on whether a journal that whirls is in contact; a single one opens whatever its friction is."""
    return sliding(planes) if len(planes.sites) > 1 else (*strain(planes), "sites[*].law", *FREE_SPIN, *MAGNETS)


def forces(planes: Planes) -> tuple[str, ...]:
    """What the contact forces depend on; without spin and whirl the contacts roll."""
    return (*sliding(planes), "sites[*].race_inertia")
