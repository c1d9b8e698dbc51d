"""The stages of a machine, as coefficients of its linear models, and as seals of the rotor in co-simulations.

The tilt stiffness of the thrust disc is modelled in the same way, but it exists only while the magnets have power.
Therefore, it is part of the linear models of the levitated rotor. Co-simulations include it only if the magnets have
power throughout.

The mass matrix of a plant does not depend on the speed, so it uses the mass of a stage at the machine's largest speed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from amb_analysis.studies.coefficient_limits import CoefficientLimits, limit_notes, limits_of
from amb_assessment.assessment.format.machine_file import CompressorStage
from amb_assessment.assessment.physics.assessed_machine import AssessedMachine
from amb_cosim.scenario.scenario import Scenario
from array_types import Array
from rotor_analysis.parts import COEFFICIENTS, AtSpeed, Bearing, table_speeds
from rotor_analysis.refinement import with_samples
from rotor_analysis.rotor import Rotor


def anticipated(subject: AssessedMachine, factor: float = 1.0) -> tuple[Bearing, ...]:
    """Return the anticipated coupling of the stages, multiplied by a factor, and terms that cancel the rotor's seals.

    The coupling is evaluated at the largest speed. These are the coefficients of the level I model, which consists of
    the rotor, its bearings (including the one along z), and a coupling that represents all causes of whirl.
    """
    speed = subject.file.speed.highest
    stages = (
        cross_coupling(s.at, subject.rotor.node_of(s.at), factor * s.anticipated(speed)) for s in subject.file.stages
    )
    return (*stages, *(_cancelling(seal) for seal in subject.rotor.seals), *subject.thrust_tilt)


def real_coefficients(subject: AssessedMachine) -> tuple[Bearing, ...]:
    """Return the level II coefficients of the stages and the thrust disc, without the seals.

    By default, a stage has its anticipated coupling.
    """
    speed = subject.file.speed.highest
    stages = (_level_two(stage, stage.at, subject.rotor.node_of(stage.at), speed) for stage in subject.file.stages)
    return (*stages, *subject.thrust_tilt)


def with_tables(subject: AssessedMachine, speeds: Array) -> Array:
    """Return `speeds` (rad/s, ascending) and the speeds between them in the tables of controller, seals and stages."""
    return with_samples(speeds, [*subject.table_speeds, *table_speeds(real_coefficients(subject))])


def table_notes(subject: AssessedMachine, highest: float) -> list[str]:
    """Return sentences on tables of seals, stages and controller that do not extend from 0 to a highest speed (rad/s).

    Coefficients that are frozen at a whirl frequency are also listed.
    """
    limits = limits_of((*subject.rotor.seals, *real_coefficients(subject)))
    laws = subject.linear_components.table_speeds()
    if len(laws) > 1:
        limits = (*limits, CoefficientLimits(("controller",), laws[0], laws[-1], None))
    return [f"{note}." for note in limit_notes(limits, (0.0, highest))]


def cross_coupling(name: str, node: int, Q: float) -> Bearing:
    """Return a cross-coupled stiffness Q (N/m) that drives forward whirl: f = -K q with K = [[0, Q], [-Q, 0]]."""
    return Bearing(name, node, ((0.0, Q), (-Q, 0.0)))


def _level_two(stage: CompressorStage, name: str, node: int, Omega: float) -> Bearing:
    """Return the level II coefficients of a stage."""
    result = stage.coefficients()
    return (
        cross_coupling(name, node, stage.level_two(Omega)) if result is None else replace(result, name=name, node=node)
    )


def _cancelling(seal: Bearing) -> Bearing:
    """Return coefficients that cancel a seal of the rotor."""

    def negated(coefficients: Bearing | AtSpeed) -> dict[str, Any]:
        return {name: (-np.array(getattr(coefficients, name))).tolist() for name in COEFFICIENTS}

    return replace(seal, **negated(seal), at_speed=tuple(replace(row, **negated(row)) for row in seal.at_speed))


def co_simulated(subject: AssessedMachine, Omega: float, *, levitated: bool = False, **fields: Any) -> Scenario:
    """Return the machine's scenario at a speed (rad/s); its stages act on the rotor like seals.

    If `levitated` is true, the magnets have power throughout, so the tilt stiffness of the thrust disc acts as well.
    """
    rotor, stages = subject.prepared.scenario.rotor, subject.file.stages
    tilts = subject.thrust_tilt if levitated else ()
    if stages or tilts:
        staged = with_stages(subject.rotor, stages, subject.file.speed.highest)
        rotor = replace(staged, seals=(*staged.seals, *tilts))
    return subject.file.as_scenario(Omega, **fields).model_copy(update={"rotor": rotor})


def with_stages(rotor: Rotor, stages: Sequence[CompressorStage], Omega: float) -> Rotor:
    """Return a rotor to which stages are added as seals with level II coefficients, at the parts that the stages name.

    Parameters
    ----------
    rotor, stages
        The rotor, and the stages that act at its parts.
    Omega
        Largest speed (rad/s), at which the anticipated coupling and the mass are evaluated.
    """
    nodes, seals = rotor.nodes_by_name, list(rotor.seals)
    names = {*nodes}
    for stage in stages:
        free = (f"{stage.at}_stage{k or ''}" for k in range(len(names) + 1))
        name = next(item for item in free if item not in names)
        names.add(name)
        seal = _level_two(stage, name, nodes[stage.at], Omega)
        mass = seal.at(Omega)[2].tolist()
        rows = ((row.speed, *(tensor.tolist() for tensor in seal.at(row.speed)[:2]), mass) for row in seal.at_speed)
        seals.append(replace(seal, at_speed=tuple(AtSpeed(*row) for row in rows)))
    return replace(rotor, seals=tuple(seals))
