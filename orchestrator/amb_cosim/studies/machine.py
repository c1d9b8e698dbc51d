"""What a prepared run of a levitated rotor starts with: parameters, speed, and the rotor's bearings and sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from amb_actuator.records import AXIS
from amb_cosim.design.magnetic_bearing import axis_parameters
from amb_cosim.design.rotor_models import control_loop
from amb_cosim.results.places import ACTUATOR, PLANT
from amb_cosim.scenario.simulation import PlannedRun
from rolac_controller.control_loop import ControlLoop
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor


@dataclass(frozen=True)
class Machine:
    """Parameters, speed and rotor of a run.

    parameters
        Values of the FMUs' parameters by component and name (SI).
    Omega
        Spin speed (rad/s).
    rotor
        Its description.
    """

    parameters: Mapping[str, Mapping[str, float]]
    Omega: float
    rotor: Rotor

    @cached_property
    def controlled(self) -> ControlLoop:
        """Bearings and sensor planes of the rotor, and how they belong together."""
        return control_loop(self.rotor)

    def of_axis(self, component: str, bearing: str, direction: str, name: str) -> float:
        """Return a parameter of one axis."""
        return self.parameters[component][f"{bearing}.{name}_{direction}"]

    def bearing_axis(self, bearing: str, direction: str) -> np.record:
        """Return the parameters of the actuator of one axis, its own static current among them."""
        values = {n: self.of_axis(ACTUATOR, bearing, direction, n) for n in AXIS.names or ()}
        return axis_parameters(bearing, direction, **values)


def machine_of(prepared: PlannedRun, *needed: str) -> Machine:
    """Return the machine of a prepared run.

    Raises
    ------
    ValueError
        If the run lacks plant, actuator, or a component that is `needed` besides.
    """
    parameters = {
        component: {name: value or 0.0 for name, value in values.items()}
        for component, values in prepared.plan.all_parameters(prepared.interfaces).items()
    }
    missing = [component for component in (PLANT, ACTUATOR, *needed) if component not in parameters]
    if missing:
        raise ValueError(f"scenario {prepared.name} has no component {missing[0]}; a linear loop needs one")
    return Machine(parameters, prepared.plan.speed, load_rotor(prepared.scenario.rotor))
