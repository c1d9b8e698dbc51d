"""Description of a machine file as text."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.constants import mu_0

from amb_actuator.actuator import coil_currents
from amb_actuator.force import static_pull
from amb_assessment.assessment.format.criteria import Criterion, unread
from amb_assessment.assessment.format.retainer_bearings import (
    DATA_HEADS,
    MOUNTED,
    MOUNTED_HEADS,
    STANDING,
    STANDING_HEADS,
    TITLE,
    check_sites,
)
from amb_assessment.assessment.format.thrust_bearing import DATA_HEADS as DATA_OF_THRUST
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.lying_rotor import carried_masses as lain_on
from amb_cosim.model_constants.magnetic_bearing import current_range, linearisation, operating_constants
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, number
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from array_types import Array
from rotor_analysis.static_load import carried_with_seals
from thrust_bearings.disc import ThrustDisc

MAGNET_HEADS = (
    "gap (mm)",
    "upper coils (A)",
    "lower coils (A)",
    "least (N)",
    "largest (N)",
    "K_s (MN/m)",
    "K_i (N/A)",
    "L (mH)",
    "L of the gap (mH)",
)
AGREES = 0.1  # largest relative difference of the axial magnet's constants in runs and in the machine file
LEAKAGE = 4.0  # factor between the inductances of file and gap, above which the file is in doubt


def description(subject: AssessedMachine, criteria: Sequence[Criterion]) -> list[TextBlock]:
    """Return tables of a machine's bearings, sensors, retainers and stages, and lines about its speeds and criteria."""
    rotor, z, speed = subject.rotor, subject.z, subject.file.speed
    springs = {b.name: b.stiffness[0][0] for b in subject.passive_bearings if b.name not in subject.magnets}
    carried = carried_with_seals(rotor, springs, subject.Omega)
    angle = subject.parameters[PLANT]["gravity_angle"]
    down = np.array([np.cos(angle), np.sin(angle)])
    bearings = labelled_table(f"Bearings of {rotor.name}", "bearing", "z (mm)", "share of the mass (kg)", "magnet")
    for bearing in rotor.bearings:
        magnet = "yes" if bearing.name in subject.magnets else "no"
        share = down @ carried[bearing.name] @ down
        bearings.add_row(bearing.name, number(1e3 * z[bearing.node - 1]), number(share), magnet)
    magnets = labelled_table("Magnets at rest", "axis", *MAGNET_HEADS)
    doubts: list[str] = []
    for name, axis in subject.loop.axes:
        numbers = magnet_numbers(subject.axis(name, axis), int(subject.parameters[ACTUATOR]["force_law"]))
        magnets.add_row(f"{name}.{axis}", *map(number, numbers))
        doubts += inductance_doubt(f"{name}.{axis}", *numbers[-2:])
    sensors = labelled_table("Sensors", "plane", "z (mm)")
    for name, node in subject.probes.items():
        sensors.add_row(name, number(1e3 * z[node - 1]))
    sites = labelled_table("Contact sites, and air gaps", "place", "z (mm)", "radial clearance (mm)", "offset (mm)")
    for name, place in subject.clearances.items():
        sites.add_row(name, *(number(1e3 * of) for of in (z[place.node - 1], place.clearance, place.offset)))
    stages = labelled_table("Stages with cross coupling", "at", "anticipated (MN/m)")
    for stage in subject.file.stages:
        stages.add_row(stage.at, f"{1e-6 * stage.anticipated(speed.highest):.4g}")
    has_moments = any(seal.tilting is not None for seal in rotor.seals)
    heads: tuple[str, ...] = ("seal", "z (mm)", "K (MN/m)", "C (kN s/m)", "M (kg)")
    heads += ("tilt K (N m/rad)", "tilt C (N m s/rad)") if has_moments else ()
    seals = labelled_table("Seals and passive bearings at the largest speed", *heads)
    for seal in rotor.seals:
        tensors = [scale * tensor for scale, tensor in zip((1e-6, 1e-3, 1.0), seal.at(speed.highest), strict=True)]
        if has_moments:
            tensors += seal.tilting.at(speed.highest)[:2] if seal.tilting is not None else 2 * [np.zeros((2, 2))]
        seals.add_row(seal.name, number(1e3 * z[seal.node - 1]), *(_tensor(item) for item in tensors))
    check_sites(subject.file.retainer_bearings, subject.sites)
    along, across = subject.file.axial_gravity, abs(subject.gravity_across)
    balls = labelled_table(f"{TITLE}, under their share of the weight across the shaft", "retainer", *DATA_HEADS)
    loads = lain_on(subject) if subject.file.retainer_bearings and (across or not along) else {}
    mounted, soft = labelled_table(MOUNTED, *MOUNTED_HEADS), list[str]()
    for item in subject.file.retainer_bearings:
        weight = (across or STANDARD_GRAVITY) * loads.get(item.at, 0.0)
        balls.add_row(*item.data(weight))
        mount = _mount(subject, item.at)
        if mount > 0.0 and weight > 0.0:
            row, sentence = item.mounted(weight, subject.sites[item.at].clearance, mount)
            mounted.add_row(*row)
            soft += [sentence] if sentence else []
    standing = labelled_table(STANDING, *STANDING_HEADS)
    for item in subject.file.retainer_bearings:
        if item.at == subject.stands_on:
            standing.add_row(*item.standing(abs(along) * rotor.mass, speed.highest))
    axial = labelled_table("Thrust bearing", "at", *DATA_OF_THRUST)
    if subject.file.thrust_bearing is not None:
        axial.add_row(subject.file.thrust_bearing.at, *subject.file.thrust_bearing.data(along * rotor.mass))
    facts = (
        f"{subject.file.name}: {rotor.mass:.4g} kg, {rpm(speed.lowest):.0f} to {rpm(speed.highest):.0f} rpm, trip at "
        f"{rpm(speed.tripping):.0f} rpm, G {1e3 * subject.file.balancing.speed:g}, "
        f"sampled every {subject.loop.sample_time:g} s"
    )
    criteria_line = f"{len(criteria)} criteria, {unread(criteria)} of them written without access to the standard"
    if not across and not along:
        criteria_line += "; the machine has no gravity, so its rotor cannot land"
    if along:
        criteria_line += (
            f"; {abs(along) * rotor.mass:.4g} N of the weight act along the shaft, and no radial bearing carries them"
        )
    warnings = [f"warning: {sentence}" for sentence in subject.prepared.warnings]
    tables: list[TextBlock] = [facts, bearings, magnets, *doubts, sensors, sites]
    tables += [axial, *thrust_doubt(subject)] if subject.file.thrust_bearing is not None else []
    tables += [balls] if subject.file.retainer_bearings else []
    tables += [mounted, *soft] if mounted.row_count else []
    tables += [standing] if standing.row_count else []
    return [
        *tables,
        *([seals] if rotor.seals else []),
        *([stages] if subject.file.stages else []),
        criteria_line,
        *warnings,
    ]


def _mount(subject: AssessedMachine, site: str) -> float:
    """Return the larger stiffness (N/m) of the mount of a retainer; 0 if its housing is rigid."""
    parameters = subject.parameters[PLANT]
    return max(parameters.get(f"{site}.mount_stiffness_{axis}", 0.0) for axis in "xy")


def magnet_numbers(p: np.record, law: int) -> tuple[float, ...]:
    """Return the gap (mm), coil currents (A), forces (N), K_s (MN/m), K_i (N/A) and inductances (mH) of an axis.

    There are two coil currents (upper and lower coils), two forces (smallest and largest) and two inductances. The
    first inductance is from the file. The second is computed from the gap: L = 2 mu_0 N^2 A/s_0 for a coil pair with N
    turns per pole, without leakage and iron.

    Parameters
    ----------
    p, law
        Parameters of an axis, and the force law of the actuator.
    """
    k_s, k_i = operating_constants(p, law)
    least, most = (float(linearisation(p, 0.0, i_c).force + static_pull(p)) for i_c in current_range(p))
    gap_inductance = 2.0 * mu_0 * p.turns**2 * p.pole_area / p.gap
    currents = coil_currents(p)
    numbers = (1e3 * p.gap, *currents, least, most, 1e-6 * k_s, k_i, 1e3 * p.inductance, 1e3 * gap_inductance)
    return tuple(map(float, numbers))


def thrust_doubt(subject: AssessedMachine) -> list[str]:
    """Return a warning if the axial magnet in runs differs from the thrust bearing of the machine file.

    Under the weight alone, K_s or K_i differs by more than `AGREES`. The scenario states the current of the coil that
    carries no weight, and the machine file states the current of both coils without a load.
    """
    bearing, axes = subject.file.thrust_bearing, [axis for axis in subject.loop.axes if axis[1] == "z"]
    load = 0.0 - subject.file.axial_gravity * subject.rotor.mass
    if bearing is None or not axes or abs(load) > bearing.bearing.capacity:
        return []
    point, name = bearing.bearing.operating_point(load), axes[0][0]
    k_s, k_i = operating_constants(subject.axis(*axes[0]), int(subject.parameters[ACTUATOR]["force_law"]))
    if max(abs(k_s / point.k_s - 1.0), abs(k_i / point.k_i - 1.0)) <= AGREES:
        return []
    constants = "K_s {:.4g} MN/m and K_i {:.4g} N/A"
    doubt = (
        f"{name}.z: under the weight of {abs(load):.4g} N, the magnet of the scenario has "
        f"{constants.format(1e-6 * k_s, k_i)}, but [thrust_bearing] has "
        f"{constants.format(1e-6 * point.k_s, point.k_i)}"
    )
    if isinstance(bearing.bearing, ThrustDisc) and load:
        lower = bearing.bearing.bias_current - abs(point.current)
        doubt += f"; for the same coils, the scenario needs {name}.bias_current_z = {lower:.4g} A"
    return [f"{doubt}; runs and the parts axial and axial_margins judge different magnets"]


def inductance_doubt(axis: str, value: float, gap_inductance: float) -> list[str]:
    """Return a warning if an inductance (mH) and the one computed from the gap differ by more than a factor `LEAKAGE`.

    Leakage and iron cause smaller differences. A larger difference suggests that a unit is missing or that the data
    belong to another magnet.
    """
    if gap_inductance / LEAKAGE <= value <= gap_inductance * LEAKAGE:
        return []
    doubt = (
        f"inductance_{axis[-1]} = {value:.4g} mH, but turns, area and gap give {gap_inductance:.4g} mH: check its unit"
    )
    return [f"{axis}: {doubt}"]


def _tensor(values: Array) -> str:
    """Return a tensor as text, in the form `xx, xy; yx, yy`."""
    return "; ".join(", ".join(f"{number:.4g}" for number in row) for row in values)
