"""A machine under assessment: the content of its machine file, and data derived from it for the analyses."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from amb_analysis.linear.axial_loop import AxialControl
from amb_analysis.machine.machine import Machine, air_gap
from amb_assessment.assessment.format.machine_file import MachineFile
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import RPM
from amb_cosim.results.component_names import PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import share_across
from rotor_analysis.parts import Bearing
from rotor_analysis.reduced_rotor import with_modes
from rotor_analysis.rotor_file import load_rotor

NEARER = (
    "The air gap of a magnet is listed in place of its retainers if the rotor uses a larger share of the gap than of "
    "their clearances. Each place is listed with its radial clearance."
)


@dataclass(frozen=True)
class AssessedMachine(Machine):
    """A machine under assessment, at its highest speed.

    file
        Content of the machine file.
    flavour
        Flavour of the FMUs.
    """

    file: MachineFile
    flavour: Flavour

    @cached_property
    def facts(self) -> Mapping[str, float]:
        """Variables for formulas of criteria: speeds (rpm), mass (kg) and balancing grade (mm/s)."""
        speed = self.file.speed
        return {
            "N_min": speed.lowest * RPM,
            "N_mc": speed.highest * RPM,
            "N_trip": speed.tripping * RPM,
            "mass": self.rotor.mass,
            "grade": 1e3 * self.file.balancing.speed,
        }

    @cached_property
    def gravity_across(self) -> float:
        """Component of gravity across the shaft (m/s^2)."""
        plant, thrust = self.parameters[PLANT], self.rotor.thrust
        return plant["gravity"] * (share_across(plant[f"{thrust}.tilt"]) if thrust else 1.0)

    @cached_property
    def falls_onto_a_face(self) -> bool:
        """Whether a face stops the fall along the shaft."""
        return any(face.stops == self.fall for face in self.rotor.faces)

    @cached_property
    def controlled_axes(self) -> tuple[tuple[str, str], ...]:
        """The axes of the loop; the axis along the shaft is included only if faces stop the motion along it."""
        return self.loop.axes if self.rotor.faces else self.loop.lateral_axes

    @property
    def directions_of_contact(self) -> str:
        """The axes along which the base can move the rotor into contact."""
        return "xyz" if self.rotor.faces else "xy"

    @property
    def fall(self) -> str:
        """The direction of a fall along the shaft: -z or +z."""
        return "-z" if self.file.axial_gravity < 0.0 else "+z"

    @cached_property
    def axial_control(self) -> AxialControl:
        """The control of the thrust bearing, from its own file or from the axial axis in the machine's controller.

        Raises
        ------
        ValueError
            If the machine file has no thrust bearing, if neither its own file nor the machine's controller controls it,
            or if both control it but differ.
        """
        if self.file.thrust_bearing is None:
            raise ValueError(f"machine {self.file.name} has no [thrust_bearing]")
        named, channel = self.file.thrust_bearing.control, self.run_loop.axial_control
        if named is None and channel is None:
            axes = ", ".join(self.run_loop.axis_names)
            raise ValueError(
                f"the thrust bearing of {self.file.name} needs a controller: its own file, or an axis along the shaft "
                f"in the machine's controller, which has only {axes}"
            )
        if named is not None and channel is not None and named.differs_from(channel):
            raise ValueError(
                f"controller {self.file.thrust_bearing.controller} of the thrust bearing differs from the axis along "
                "the shaft of the machine's controller; omit the file, so that the axis is assessed"
            )
        control = named or channel
        assert control is not None
        return control

    @cached_property
    def faults(self) -> tuple[str, ...]:
        """Inputs that are described as faults and are not 0 at the start."""
        return self.faults_among(self.prepared.inputs)

    @cached_property
    def retainers(self) -> tuple[str, ...]:
        """Contact sites that are retainers of bearings."""
        return tuple(site.name for site in self.rotor.sites if site.bearing and site.name in self.sites)

    def faces_at(self, retainer: str) -> tuple[str, ...]:
        """Return the faces whose axial force the given retainer carries."""
        return tuple(face.name for face in self.rotor.faces if face.retainer == retainer)

    @property
    def stands_on(self) -> str:
        """The retainer on which the unpowered rotor stands, at the nearest face that stops its fall; empty if none."""
        stopping = [face for face in self.rotor.faces if self.file.axial_gravity and face.stops == self.fall]
        return min(stopping, key=lambda face: face.clearance).retainer or "" if stopping else ""

    @property
    def lands_on(self) -> tuple[str, ...]:
        """The retainers and the faces; the faces stop motion along the shaft."""
        return (*self.retainers, *(face.name for face in self.rotor.faces))

    @cached_property
    def thrust_tilt(self) -> tuple[Bearing, ...]:
        """The negative tilt stiffness of the energised thrust disc, at the static force that makes it most negative."""
        thrust = self.file.thrust_bearing
        if thrust is None:
            return ()
        k = 0.0 - thrust.largest_moment_stiffness(self.file.axial_gravity * self.rotor.mass)
        free = (f"{thrust.at}_tilt{n or ''}" for n in range(len(self.rotor.nodes_by_name) + 1))
        name = next(name for name in free if name not in self.rotor.nodes_by_name)
        return (Bearing(name, self.rotor.node_of(thrust.at), tilt_stiffness=((k, 0.0), (0.0, k))),)

    @cached_property
    def stops(self) -> tuple[str, ...]:
        """Places that stop the motion at bearings: retainers and air gaps, or all places if there are no retainers."""
        gaps = (air_gap(bearing) for bearing in self.air_gaps)
        return (*self.retainers, *gaps) if self.retainers else tuple(self.clearances)

    def nearest(self, shares: Mapping[str, float]) -> list[str]:
        """Return the places to judge for each magnet: its air gap if the share there is largest, else its retainers.

        Parameters
        ----------
        shares
            Displacement relative to the clearance, by place. Places that belong to no magnet are always judged.
        """
        guarded = {site.name: air_gap(site.bearing) for site in self.rotor.sites if site.bearing}
        groups: dict[str, list[str]] = {}
        for place in shares:
            groups.setdefault(guarded.get(place, place), []).append(place)
        result: list[str] = []
        for gap, places in groups.items():
            retainers = [place for place in places if place != gap]
            is_nearer = gap in shares and all(shares[gap] > shares[retainer] for retainer in retainers)
            result += [gap] if is_nearer else retainers
        return result

    def clearance_text(self, place: str) -> str:
        """Return the radial clearance of a place as text."""
        return f"{1e3 * self.clearances[place].clearance:.4g} mm"

    def unbalance_of_grade(self) -> float:
        """Return the unbalance m G/Omega (kg m) that the balancing grade allows at the largest speed."""
        return self.rotor.mass * self.file.balancing.speed / self.file.speed.highest

    def residual_unbalance(self) -> float:
        """Return the residual unbalance (kg m) of API 617, U_r = 6350 W/N g mm, at the largest speed."""
        return 6350e-6 * self.rotor.mass / (self.file.speed.highest * RPM)


def assessed_machine_of(file: MachineFile, flavour: Flavour = "native", modes: int | None = None) -> AssessedMachine:
    """Return the machine that a file describes.

    Parameters
    ----------
    file, flavour
        The machine file, and the flavour of the FMUs.
    modes
        Number of elastic modes that the rotor retains in each plane of motion. It replaces the reduction in the rotor
        file.
    """
    scenario = file.as_scenario(file.speed.highest)
    if modes is not None:
        scenario = scenario.changed(rotor=with_modes(load_rotor(scenario.rotor), modes))
    return AssessedMachine(prepare_run(scenario, options=RunOptions(flavour=flavour)), file, flavour)


def rpm(Omega: Any) -> Any:
    """Convert a speed from rad/s to rpm."""
    return Omega * RPM


def hertz(omega: Any) -> Any:
    """Convert a frequency from rad/s to Hz."""
    return omega / (2.0 * math.pi)
