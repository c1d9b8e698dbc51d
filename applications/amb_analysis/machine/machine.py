"""The machine of a prepared run: rotor, parameters, sampled loop, and places by name."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from amb_actuator.interface import DYNAMIC
from amb_actuator.records import AXIS
from amb_analysis.linear.linear_source import LinearSource, source_of_run
from amb_analysis.linear.loop import Loop
from amb_cosim.model_constants.magnetic_bearing import axis_parameters
from amb_cosim.model_constants.plant_data import flat_constants, plant_structure
from amb_cosim.model_constants.rotor_models import control_loop
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.plan import ScenarioPlan
from array_types import Array
from rolac_controller.control_loop import ControlLoop
from rotor_analysis.assembly import Matrices, assemble
from rotor_analysis.harmonic import harmonic_points
from rotor_analysis.modal_reduction import reduce_to_modes
from rotor_analysis.parts import Bearing, Point, table_speeds
from rotor_analysis.reduced_rotor import force_nodes
from rotor_analysis.reduction import Reduction
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.sampled_rotor import Sampling, sampled_rotor
from rotor_analysis.supported_rotor import SupportedRotor

AXES = "xy"
FAULT = "Fault:"  # prefix of the description of an input that is a fault
HIGHEST = 2.0 * math.pi * 4000.0  # rad/s, twice the 2 kHz up to which ISO 14839-3 judges sensitivities
MODES = 40  # of the free rotor in each plane; error of 1e-5 at a resonance of amplification 50


class Place(NamedTuple):
    """A place that the rotor can touch.

    node, clearance
        Node and radial clearance (m).
    signal
        Prefix of the names of the plant's displacements at this place.
    offset
        Distance (m) between the centre of the place and the centre of the levitated rotor.
    """

    node: int
    clearance: float
    signal: str
    offset: float = 0.0

    @property
    def reach(self) -> float:
        """The amplitude (m) at which an orbit touches the place, if the major axis of the orbit is along the offset."""
        return self.clearance - self.offset


@dataclass(frozen=True)
class Machine:
    """The machine of a scenario's plan."""

    prepared: ScenarioPlan
    _source: LinearSource | None = field(default=None, kw_only=True, compare=False, repr=False)

    @property
    def Omega(self) -> float:
        """Spin speed at the start (rad/s)."""
        return self.prepared.speed

    @property
    def last_speed(self) -> float:
        """Spin speed (rad/s) that the scenario prescribes at the end."""
        return self.prepared.profile[-1][1] if self.prepared.profile else self.prepared.speed

    @cached_property
    def rotor(self) -> Rotor:
        """The rotor of the machine."""
        return load_rotor(self.prepared.scenario.rotor)

    @cached_property
    def parameters(self) -> Mapping[str, Mapping[str, float]]:
        """Values of the components' parameters (SI)."""
        return {name: self.run_components.parameters(name) for name in self.run_components.names}

    @cached_property
    def run_components(self) -> LinearSource:
        """Source of the linear models of the machine's runs, with the rotor reduced as its file specifies."""
        return self._source or source_of_run(self.prepared)

    @cached_property
    def run_loop(self) -> Loop:
        """The sampled loop of the machine's runs; it differs from `loop` only in that its rotor has fewer modes."""
        return Loop(self.run_components)

    @cached_property
    def sampled_rotor(self) -> Reduction:
        """The free rotor with all modes that the control can sense, whatever reduction the rotor's file specifies."""
        return sampled_rotor(self.rotor, self._sampling, HIGHEST)

    @property
    def _sampling(self) -> Sampling:
        """Sampling and nodes of the control; without it, forces at bearings and contact sites, held over a step."""
        try:
            loop = self.run_loop
        except ValueError:
            nodes = force_nodes(self.rotor)
            return Sampling(self.prepared.step_size, nodes, tuple({*nodes, *self.rotor.sensor_nodes}))
        links = {link.target: link.source for link in self.prepared.assembly.system.connections}
        read = [links[reading].removeprefix(f"{PLANT}.") for reading in loop.readings]
        sensors = {self.signals[name][0] for name in read if name in self.signals}
        forces = {bearing.node for bearing in self.rotor.bearings if bearing.name in self.magnets}
        p = self.parameters[ACTUATOR]
        is_dynamic = p.get("amplifier") == DYNAMIC
        bandwidths = [value for name, value in p.items() if is_dynamic and ".bandwidth_" in name]
        fastest = 2.0 * math.pi * max(bandwidths, default=math.inf)
        return Sampling(loop.sample_time, tuple(forces), tuple(sensors or forces), fastest)

    @cached_property
    def linear_components(self) -> LinearSource:
        """Source of the machine's linear models, with `sampled_rotor` as the rotor."""
        source = self.run_components
        if source.kind(PLANT) != PLANT:
            return source
        structure, _ = plant_structure(self.rotor, source.plan.assembly.options.get("stators", ()), self.sampled_rotor)
        return replace(source, rotor=flat_constants(structure), _cache={})

    def with_plan(self, plan: ScenarioPlan, rotor: Rotor) -> Machine:
        """Return the machine with another plan of the same components, and with the rotor `rotor`.

        Constants of the electronics are reused. In `run_components`, the plant keeps the constants of the previous
        rotor, but `linear_components` contains the new rotor.
        """
        scenario = self.prepared.scenario.model_copy(update={"rotor": rotor})
        return Machine(replace(plan, scenario=scenario), _source=self.run_components.with_plan(plan))

    @cached_property
    def loop(self) -> Loop:
        """The sampled loop of the machine."""
        return Loop(self.linear_components)

    @cached_property
    def controlled(self) -> ControlLoop:
        """Bearings and sensor planes of the rotor, and the assignment of planes to bearings."""
        return control_loop(self.rotor)

    @cached_property
    def free(self) -> Matrices:
        """The finite-element model of the rotor without bearings and seals."""
        return assemble(self.rotor)

    @cached_property
    def free_rotor(self) -> SupportedRotor:
        """The free rotor, reduced to `MODES` modes and residual shapes of its parts, for analyses at many speeds."""
        return SupportedRotor(self.rotor, self.free, reduce_to_modes(self.free, MODES, self.rotor.part_nodes))

    @cached_property
    def passive_bearings(self) -> tuple[Bearing, ...]:
        """The plant's passive stiffness `k_b` and damping `c_b` at each bearing."""
        parameters, result = self.parameters[PLANT], []
        for bearing in self.rotor.bearings:
            k, c = (parameters.get(f"{bearing.name}.{name}", 0.0) for name in ("k_b", "c_b"))
            result.append(Bearing(bearing.name, bearing.node, ((k, 0.0), (0.0, k)), ((c, 0.0), (0.0, c))))
        return tuple(result)

    @cached_property
    def z(self) -> Array:
        """Positions of the nodes (m)."""
        return np.array(self.rotor.shaft.nodes)

    @cached_property
    def table_speeds(self) -> tuple[float, ...]:
        """Speeds (rad/s) at which the tables of controllers and seals have entries, in ascending order."""
        return tuple(sorted({*self.run_components.table_speeds(), *table_speeds(self.rotor.seals)}))

    @cached_property
    def magnets(self) -> tuple[str, ...]:
        """Radial bearings that have a magnet and a controller."""
        return tuple(dict.fromkeys(bearing for bearing, _ in self.run_loop.lateral_axes))

    @cached_property
    def bearings(self) -> dict[str, int]:
        """Nodes of the bearings, by name."""
        return {bearing.name: bearing.node for bearing in self.rotor.bearings}

    @cached_property
    def probes(self) -> dict[str, int]:
        """Nodes of the sensors, by name."""
        return {sensor.name: sensor.node for sensor in self.rotor.sensors}

    @cached_property
    def axial_row(self) -> int:
        """Row of the displacement along the shaft, after the rows of `harmonic_points`, if there is a thrust disc."""
        return 2 * len(harmonic_points(self.rotor))

    @cached_property
    def load_rows(self) -> Mapping[str, int]:
        """Row of each input of the plant that is a load of `harmonic` (2): forces on the rotor, and base accelerations.

        The rows are x and y of `harmonic_points`, then the force along the shaft and the accelerations of the base.
        """
        layout, points = self.run_components.layout(PLANT), harmonic_points(self.rotor)
        places = (*layout["discs"], *layout["bearings"])
        rows = {
            f"{place}.f_{axis}": 2 * points.index(self.rotor.point_of(place)) + k
            for place in places
            for k, axis in enumerate(AXES)
        }
        after, base = self.axial_row, AXES
        if thrust := self.rotor.thrust:
            rows |= {f"{thrust}.f_z": after, f"{thrust}.f_process": after}
            after, base = after + 1, AXES + "z"
        rows |= {f"base.a_{axis}": after + k for k, axis in enumerate(base)}
        return {f"{PLANT}.{name}": row for name, row in rows.items()}

    @cached_property
    def sites(self) -> dict[str, Place]:
        """The contact sites of the rotor that are enabled, by name."""
        parameters = self.parameters[PLANT]
        enabled = (site for site in self.rotor.sites if parameters.get(f"{site.name}.enabled", 1.0))
        radii = {site: parameters.get(f"{site.name}.clearance", site.clearance) for site in enabled}
        offsets = {
            site: math.hypot(*(parameters.get(f"{site.name}.offset_{axis}", 0.0) for axis in AXES)) for site in radii
        }
        return {site.name: Place(site.node, radii[site], site.name, offsets[site]) for site in radii}

    @cached_property
    def air_gaps(self) -> dict[str, Place]:
        """The stator bores of the magnets, by bearing; their clearance is the smaller air gap of the two axes."""
        parameters = self.parameters[ACTUATOR]
        gaps_of = {
            name: [parameters[gap] for gap in (f"{name}.gap_{a}" for a in AXES) if gap in parameters]
            for name in self.magnets
        }
        return {name: Place(self.bearings[name], min(gaps), name) for name, gaps in gaps_of.items() if gaps}

    @cached_property
    def clearances(self) -> dict[str, Place]:
        """All places that the rotor can touch, by name: contact sites, and air gaps of magnets."""
        return self.sites | {air_gap(bearing): place for bearing, place in self.air_gaps.items()}

    @cached_property
    def last_inputs(self) -> Mapping[str, float]:
        """Values of the inputs at the end of the run, after the last events, by `component.variable`."""
        plan = self.prepared
        in_time = sorted((event for event in plan.events if event[0] < plan.last), key=lambda event: event[0])
        return {**plan.inputs, **{name: value for _, name, value in in_time}}

    def faults_among(self, inputs: Mapping[str, float]) -> tuple[str, ...]:
        """Return the inputs that are not 0 and are described as faults."""
        ports = {
            f"{component}.{name}": port
            for component, interface in self.prepared.interfaces.items()
            for name, port in interface.ports.items()
        }
        active = (name for name, value in inputs.items() if value and name in ports)
        return tuple(name for name in active if ports[name].description.startswith(FAULT))

    @cached_property
    def unbalance(self) -> Mapping[str, complex]:
        """Unbalance (kg m) at the end of the run, by disc or bearing."""
        layout, last = self.run_components.layout(PLANT), self.last_inputs
        amounts = {place: last.get(f"{PLANT}.{place}.u", 0.0) for place in (*layout["discs"], *layout["bearings"])}
        return {place: u * cmath.exp(1j * last.get(f"{PLANT}.{place}.phi", 0.0)) for place, u in amounts.items()}

    @cached_property
    def unbalanced_points(self) -> dict[Point, complex]:
        """Unbalance (kg m) at each unbalanced node or centre of mass, summed over the places there."""
        result: dict[Point, complex] = {}
        for place, u in self.unbalance.items():
            if u:
                point = self.rotor.point_of(place)
                result[point] = result.get(point, 0.0) + u
        return result

    @cached_property
    def signals(self) -> dict[str, tuple[int, int]]:
        """Node and axis of each displacement among the plant's outputs, by the name of the output."""
        named = [(f"{part.name}.{axis}", part.node, k) for part in self.rotor.bearings for k, axis in enumerate(AXES)]
        named += [(name, s.node, k) for s in self.rotor.sensors for k, name in enumerate((s.x, s.y))]
        named += [(f"{site.name}.{axis}", site.node, k) for site in self.rotor.sites for k, axis in enumerate(AXES)]
        return {name: (node, k) for name, node, k in reversed(named)}

    @cached_property
    def base_movers(self) -> tuple[str, ...]:
        """Components that accelerate the base, such as a casing."""
        links = {link.target: link.source for link in self.prepared.assembly.system.connections}
        base = (f"{PLANT}.base.a_{axis}" for axis in AXES)
        return tuple(dict.fromkeys(links[name].partition(".")[0] for name in base if name in links))

    def axis(self, bearing: str, direction: str) -> np.record:
        """Return the actuator's parameters of an axis, including its static current."""
        parameters = self.parameters[ACTUATOR]
        values = {name: parameters[f"{bearing}.{name}_{direction}"] for name in AXIS.names or ()}
        return axis_parameters(bearing, direction, **values)


def air_gap(bearing: str) -> str:
    """Return the name of the air gap of a bearing's magnet."""
    return f"air gap of {bearing}"


def machine_of(prepared: ScenarioPlan, *needed: str) -> Machine:
    """Return the machine of a prepared run.

    Raises
    ------
    ValueError
        If the run lacks the plant, or another component that is `needed`.
    """
    missing = [component for component in (PLANT, *needed) if component not in prepared.interfaces]
    if missing:
        raise ValueError(f"scenario {prepared.name} has no component {missing[0]}, which the study requires")
    return Machine(prepared)
