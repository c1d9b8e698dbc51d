"""The smallest friction coefficient that drives an unpowered machine into whirl.

With gravity across its shaft, a rotor enters backward whirl by swinging over the top of its retainers. An upright rotor
rests on a face, where friction makes the whirl grow until the race below the face turns with the rotor.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amb_analysis.linear.linear_source import source_of_run
from amb_analysis.steady_contact.face_whirl import StandingRotor, standing_rotor
from amb_analysis.steady_contact.swing import MOST, least_swinging_friction, whirl_forces
from amb_analysis.steady_contact.unpowered import relative_receptances
from amb_assessment.assessment.format.quantities import Quantity, declare
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine, rpm
from amb_assessment.assessment.physics.lying_rotor import clearances, lying_on
from amb_assessment.assessment.physics.stages import co_simulated
from amb_cosim.scenario.gravity import STANDARD_GRAVITY
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from rotor_analysis.refinement import refined
from rotor_analysis.rotor_file import load_rotor

declare("whirl_friction", "1", ("friction", "on_face"))

SPEEDS = 5  # from standstill to the trip speed, before refinement about minima
UNKNOWN = 3.0  # factor by which the stiffness of a face may differ, since nobody has measured it
MARGIN = 2.0  # of this friction over that of landings, as in the criteria; above it no landing whirls by chance


def whirl_friction(subject: AssessedMachine, friction: float) -> Quantity:
    """Return the smallest friction coefficient that causes whirl at any speed up to the trip speed.

    The whirl is in one or two retainers (`swing`) or, for an upright rotor, on the face on which it stands
    (`face_whirl`).

    Parameters
    ----------
    subject
        The machine, with seals and stages.
    friction
        Largest friction coefficient of the landings; criteria compare it with the result.
    """
    standing = not subject.gravity_across and subject.falls_onto_a_face
    find = _least_friction_on_face if standing else _least_friction
    least: Quantity = subject.linear_components.cached("whirl friction", lambda: find(subject))
    open_ended = least.may_worsen_because
    if standing and not open_ended and least.facts["stiffer"] < MARGIN * friction:
        open_ended = (
            f"on a face {UNKNOWN:g} times as stiff, friction of {least.facts['stiffer']:.3g} or more drives whirl"
        )
    facts = {"friction": friction, "on_face": float(standing)}
    return replace(least, facts=facts, may_worsen_because=open_ended)


def _least_friction_on_face(subject: AssessedMachine) -> Quantity:
    """Return the smallest friction that causes whirl of a standing rotor.

    Its `facts` contain the value for a face that is `UNKNOWN` times as stiff.
    """
    weight, tripping = subject.rotor.mass * abs(subject.file.axial_gravity), subject.file.speed.tripping
    faces = [k for k, face in enumerate(subject.rotor.faces) if face.stops == subject.fall]
    scenario = co_simulated(subject, subject.file.speed.highest)

    def on_faces(scenario: Scenario) -> dict[str, StandingRotor]:
        linear_source = source_of_run(prepare_run(scenario))
        return {
            f"{subject.rotor.faces[face].name}, {rpm(Omega):.0f} rpm": standing_rotor(
                linear_source, face, Omega, weight
            )
            for face in faces
            for Omega in np.linspace(tripping / SPEEDS, tripping, SPEEDS).tolist()
        }

    standing = on_faces(scenario)
    (value, where), (stiffer, _), (softer, _) = (
        min((rotor.least_driving(factor), name) for name, rotor in standing.items())
        for factor in (1.0, UNKNOWN, 1.0 / UNKNOWN)
    )
    note = (
        "friction at which whirl grows twentyfold before the race turns with the rotor; the assumed stiffness of the "
        f"face has not been measured: with {UNKNOWN:g} times this stiffness, the value is {stiffer:.3g}; with a third "
        f"of this stiffness, it is {softer:.3g}"
    )
    where += f" (least of {rpm(tripping / SPEEDS):.0f} rpm to {rpm(tripping):.0f} rpm)"
    drift, may_worsen = max(rotor.drift for rotor in standing.values()), ""
    if drift:
        without_seals = replace(load_rotor(scenario.rotor), seals=())
        free = on_faces(scenario.model_copy(update={"rotor": without_seals})).values()
        growth = f"without any friction, the rotor drifts on its face with a growth of {drift:.3g} 1/s"
        if any(rotor.topples for rotor in free):
            may_worsen = f"{growth}, because the face is too soft or too small to hold it upright"
        elif any(rotor.drift for rotor in free):
            may_worsen = f"{growth}, because damping turns with its shaft"
        else:
            note += (
                f"; {growth}, because of the coefficients of stages and seals, until it touches the bores of its "
                "retainers; that is not counted as whirl"
            )
    return Quantity("whirl_friction", where, value, "1", {"stiffer": stiffer}, note, may_worsen)


def _least_friction(subject: AssessedMachine) -> Quantity:
    if not subject.gravity_across and subject.file.axial_gravity:
        note = "gravity acts only along the shaft, so the rotor cannot swing over the top of its retainers"
        return Quantity("whirl_friction", "upright", MOST, "1", note=note, chaotic=note)
    highest = subject.file.speed.tripping
    scenario = co_simulated(subject, subject.file.speed.highest)
    linear_source, seals = source_of_run(prepare_run(scenario)), load_rotor(scenario.rotor).seals
    c = clearances(subject)
    across = abs(subject.gravity_across)
    g = across or STANDARD_GRAVITY
    sets, masses, heights = zip(*lying_on(subject), strict=True)

    def least(Omega: float) -> list[float]:
        relative = relative_receptances(linear_source, Omega, subject.retainers)
        weights = [across * float(c[at] @ mass / c[at].mean()) for at, mass in zip(sets, masses, strict=True)]
        held = any(np.diag(seal.at(Omega)[0]).any() for seal in seals)
        forces = [whirl_forces(relative, at, c[at], g, held=held) for at in sets]
        return [least_swinging_friction(F, W, g, h) for F, W, h in zip(forces, weights, heights, strict=True)]

    speeds, values = refined(
        lambda speeds: np.array([least(float(Omega)) for Omega in speeds]),
        np.linspace(0.0, highest, SPEEDS),
        lambda values: -values,
        resonant=False,
    )
    n, k = np.unravel_index(int(values.argmin()), values.shape)
    value, where = float(values[n, k]), " and ".join(subject.retainers[j] for j in sets[k])
    usual = (
        "for rigid retainers without damping, the value is 0.237, or less if the gyroscopic effect is strong or if "
        "these retainers carry a small share of the weight"
    )
    note = f"no whirl up to {MOST:g}" if value >= MOST else usual
    where += f", {rpm(speeds[n]):.0f} rpm (least of 0 rpm to {rpm(highest):.0f} rpm)"
    return Quantity("whirl_friction", where, value, "1", note=note)


def chance(least: Quantity) -> str:
    """Return why chance decides whether the rotor whirls in a landing, or "" if the friction is too small for whirl."""
    friction = least.facts["friction"]
    if least.value >= MARGIN * friction:
        return ""
    return (
        f"friction of {friction:g} is more than half of the {least.value:.3g} that drives a falling rotor into whirl, "
        "so the outcome of each landing depends on chance"
    )


def whirl_facts(least: Quantity) -> dict[str, float]:
    """Return the variables for criteria on landings: `whirl_friction`, and the largest friction of the landings."""
    return {"whirl_friction": least.value, "friction": least.facts["friction"]}
