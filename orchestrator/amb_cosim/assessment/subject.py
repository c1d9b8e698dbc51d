"""The machine of a file as analyses need it: its rotor, its parameters, its sampled loop, and places by name."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from amb_actuator.records import AXIS
from amb_cosim.assessment.machine_file import MachineFile
from amb_cosim.assessment.with_stages import machine_with_stages
from amb_cosim.cosim.basics.choices import Flavour
from amb_cosim.cosim.system.values import RPM
from amb_cosim.design.magnetic_bearing import axis_parameters
from amb_cosim.linear.linearisable import LinearSource, of_prepared
from amb_cosim.linear.loop import Loop
from amb_cosim.results.places import ACTUATOR, PLANT
from amb_cosim.scenario.simulation import PlannedRun, prepare
from amb_files.suggestions import suggest
from fmi_export.model import Array
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.reduction import Reduction, craig_bampton
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor

AXES = "xy"
MODES = 40  # of the rotor held at its parts, in each plane: 1e-5 off all elements at a resonance of amplification 50


@dataclass(frozen=True)
class Subject:
    """A machine under assessment.

    file
        What the machine file says.
    flavour
        Flavour of the FMUs.
    """

    file: MachineFile
    flavour: Flavour = "native"

    @cached_property
    def prepared(self) -> PlannedRun:
        """The machine's run at its largest speed, ready to start."""
        return prepare(self.file.as_scenario(self.file.speed.highest), None, flavour=self.flavour)

    @cached_property
    def co_simulated(self) -> MachineFile:
        """The machine as it is co-simulated: stages at planes of the plant act on the rotor as seals do."""
        left_out = self.stages_left_out
        stages = [stage for stage in self.file.stages if stage.at not in left_out]
        return machine_with_stages(self.file, stages, self.prepared.scenario.rotor, self._folder)

    @cached_property
    def stages_left_out(self) -> tuple[str, ...]:
        """Parts with stages that are not in co-simulation, because the plant has no plane there.

        More planes would add modes far above those that the reduction of the rotor file keeps: nothing damps them, and
        sampled control may drive them.
        """
        planes = reduced_rotor(self.rotor).model.translations
        return tuple(stage.at for stage in self.file.stages if self.node_of(stage.at) not in planes)

    @property
    def note_on_stages(self) -> tuple[str, ...]:
        """What a reader of a co-simulation must know of the stages."""
        if not self.stages_left_out:
            return ()
        places = ", ".join(self.stages_left_out)
        return (f"Stages that are not in co-simulation, because the rotor's reduction has no plane there: {places}.",)

    @cached_property
    def _folder(self) -> tempfile.TemporaryDirectory[str]:
        return tempfile.TemporaryDirectory()

    @cached_property
    def linear_components(self) -> LinearSource:
        """What its linear models are made from."""
        return of_prepared(self.prepared)

    @cached_property
    def loop(self) -> Loop:
        """Its sampled loop."""
        return Loop(self.linear_components)

    @cached_property
    def rotor(self) -> Rotor:
        """Its rotor."""
        return load_rotor(self.prepared.scenario.rotor)

    @cached_property
    def free(self) -> Matrices:
        """The finite-element model of the rotor, without its magnetic bearings."""
        return assemble(self.rotor)

    @cached_property
    def condensed(self) -> Reduction:
        """The rotor condensed to the nodes of its parts and `MODES` modes, for responses at many speeds."""
        nodes = {*self.rotor.part_nodes, 1, len(self.rotor.shaft.nodes)}
        inner = 2 * len(self.rotor.shaft.nodes) - len(nodes)
        return craig_bampton(self.free, tuple(sorted(nodes)), min(MODES, inner))

    @cached_property
    def parameters(self) -> Mapping[str, Mapping[str, float]]:
        """Values of the components' parameters (SI)."""
        result = self.prepared.plan.all_parameters(self.prepared.interfaces)
        return {component: {name: value or 0.0 for name, value in of.items()} for component, of in result.items()}

    @cached_property
    def z(self) -> Array:
        """Positions of the nodes (m)."""
        return np.array(self.rotor.shaft.nodes)

    @cached_property
    def magnets(self) -> tuple[str, ...]:
        """Bearings that have a magnet and a controller."""
        return tuple(dict.fromkeys(bearing for bearing, _ in self.loop.axes))

    @cached_property
    def probes(self) -> dict[str, int]:
        """Nodes of the sensors, by name."""
        return {sensor.name: sensor.node for sensor in self.rotor.sensors}

    @cached_property
    def clearances(self) -> dict[str, tuple[int, float]]:
        """Nodes and radial clearances (m) of the places that the rotor can touch, by name."""
        local = self.parameters[PLANT]
        enabled = (site for site in self.rotor.sites if local.get(f"{site.name}.enabled", 1.0))
        return {site.name: (site.node, local.get(f"{site.name}.clearance", site.clearance)) for site in enabled}

    @cached_property
    def signals(self) -> dict[str, tuple[int, int]]:
        """Node and axis of the displacements that the plant shows, by the names of its outputs."""
        named = [(f"{part.name}.{axis}", part.node, k) for part in self.rotor.bearings for k, axis in enumerate(AXES)]
        named += [(name, s.node, k) for s in self.rotor.sensors for k, name in enumerate((s.x, s.y))]
        named += [(f"{site.name}.{axis}", site.node, k) for site in self.rotor.sites for k, axis in enumerate(AXES)]
        return {name: (node, k) for name, node, k in reversed(named)}

    def node_of(self, part: str) -> int:
        """Return the node of a part of the rotor.

        Raises
        ------
        ValueError
            If it has none of this name.
        """
        rotor = self.rotor
        parts = {p.name: p.node for p in (*rotor.bodies, *rotor.bearings, *rotor.seals, *rotor.sites, *rotor.sensors)}
        if part not in parts:
            raise ValueError(f"rotor {rotor.name} has no part {part!r}; {suggest(part, parts)}")
        return parts[part]

    def axis(self, bearing: str, direction: str) -> np.record:
        """Return the parameters of an axis of a magnetic bearing."""
        local = self.parameters[ACTUATOR]
        return axis_parameters(
            bearing, direction, **{name: local[f"{bearing}.{name}_{direction}"] for name in AXIS.names or ()}
        )

    @cached_property
    def facts(self) -> Mapping[str, float]:
        """Variables that formulas of criteria may name: speeds (1/min), mass (kg), balancing grade (mm/s)."""
        speed = self.file.speed
        return {
            "N_min": speed.lowest * RPM,
            "N_mc": speed.highest * RPM,
            "N_trip": speed.tripping * RPM,
            "mass": self.rotor.mass,
            "grade": 1e3 * self.file.balancing.speed,
        }

    def unbalance_of_grade(self, Omega: float | None = None) -> float:
        """Return the unbalance (kg m) that the balancing grade allows, m G/Omega at the largest speed."""
        return self.rotor.mass * self.file.balancing.speed / (self.file.speed.highest if Omega is None else Omega)

    def residual_unbalance(self) -> float:
        """Return the residual unbalance U_r = 6350 W/N g mm (kg m) of API 617, at the largest speed."""
        return 6350e-6 * self.rotor.mass / (self.file.speed.highest * RPM)


def rpm(Omega: Any) -> Any:
    """Return a speed in 1/min of one in rad/s."""
    return np.asarray(Omega) * RPM if not isinstance(Omega, float) else Omega * RPM


def hertz(omega: Any) -> Any:
    """Return a frequency in Hz of one in rad/s."""
    return omega / (2.0 * math.pi)
