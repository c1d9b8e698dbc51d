"""The stages of a machine, as coefficients of its linear models, and as seals of the rotor in co-simulations.

A plant's mass does not depend on the speed: a stage has its mass at the machine's largest speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from amb_analysis.machine.coefficients import WHIRL, SupportCoefficients, cross_coupling, without
from amb_assessment.assessment.machine_file import CompressorStage
from amb_assessment.assessment.subject import Subject
from amb_cosim.scenario.scenario import Scenario
from rotor_analysis.parts import Bearing
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor import Rotor


def anticipated(subject: Subject, factor: float = 1.0) -> tuple[SupportCoefficients, ...]:
    """Return the anticipated coupling of the stages at the largest speed times a factor, in place of the rotor's seals.

    This is the model of level I: rotor, bearings, and one coupling for everything that drives whirl.
    """
    speed = subject.file.speed.highest
    stages = (cross_coupling(s.at, subject.node_of(s.at), factor * s.anticipated(speed)) for s in subject.file.stages)
    return (*stages, *(without(seal) for seal in subject.rotor.seals))


def real_coefficients(subject: Subject) -> tuple[SupportCoefficients, ...]:
    """Return the stages by the better calculation of level II, by default with the anticipated coupling.

    The rotor's seals are in its model.
    """
    speed, result = subject.file.speed.highest, []
    for stage in subject.file.stages:
        node, bearing = subject.node_of(stage.at), stage.coefficients()
        local = cross_coupling(stage.at, node, stage.level_two(speed)) if bearing is None else None
        result.append(local or SupportCoefficients(stage.at, node, bearing.at))  # type: ignore[union-attr]
    return tuple(result)


def co_simulated(subject: Subject, Omega: float, **fields: Any) -> Scenario:
    """Return the machine's scenario at a speed (rad/s); stages at planes of the plant act on the rotor like seals."""
    left_out, rotor = stages_left_out(subject), subject.planned.scenario.rotor
    stages = [stage for stage in subject.file.stages if stage.at not in left_out]
    rotor = with_stages(subject.rotor, stages, subject.file.speed.highest) if stages else rotor
    return subject.file.as_scenario(Omega, **fields).model_copy(update={"rotor": rotor})


def stages_left_out(subject: Subject) -> tuple[str, ...]:
    """Return the parts with stages that are not in co-simulation, because the plant has no plane there.

    More planes would add modes far above those that the rotor file's reduction retains: nothing damps them, and sampled
    control may drive them.
    """
    planes = reduced_rotor(subject.rotor).model.translations
    return tuple(stage.at for stage in subject.file.stages if subject.node_of(stage.at) not in planes)


def note_on_stages(subject: Subject) -> tuple[str, ...]:
    """Return notes on the stages for readers of a co-simulation."""
    places = ", ".join(stages_left_out(subject))
    text = f"Stages missing in co-simulation, because the rotor's reduction has no plane there: {places}."
    return (text,) if places else ()


def with_stages(rotor: Rotor, stages: Sequence[CompressorStage], Omega: float) -> Rotor:
    """Return a rotor with stages as seals, by the better calculation, at its parts of those names.

    Parameters
    ----------
    rotor, stages
        The rotor, and stages at its parts.
    Omega
        Largest speed (rad/s), for the anticipated coupling and the mass.
    """
    nodes, seals = rotor.nodes_by_name, list(rotor.seals)
    names = {*nodes}
    for stage in stages:
        free = (f"{stage.at}_stage{k or ''}" for k in range(len(names) + 1))
        name = next(item for item in free if item not in names)
        names.add(name)
        seals.append(Bearing(name, nodes[stage.at], **_coefficients(stage, Omega)))
    return replace(rotor, seals=tuple(seals))


def _coefficients(stage: CompressorStage, Omega: float) -> dict[str, Any]:
    """Return the coefficients of a stage as a seal."""
    result = stage.coefficients()
    if result is None:
        return {"stiffness": (stage.level_two(Omega) * WHIRL).tolist()}
    mass = result.at(Omega)[2].tolist()
    if not result.at_speed:
        K, C, _ = result.at(Omega)
        return {"stiffness": K.tolist(), "damping": C.tolist(), "mass": mass}
    rows = []
    for table in result.at_speed:
        K, C, _ = result.at(table.speed)
        rows.append({"speed": table.speed, "stiffness": K.tolist(), "damping": C.tolist(), "mass": mass})
    return {"at_speed": rows}
