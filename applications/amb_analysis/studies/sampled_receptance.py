"""Receptance that the controller would identify, computed from the linear model of the loop with any controller.

    U --> u = Re[U exp(j theta)]/K_i --> D --(+)--> currents --> machine --> displacements --> F --> Q = R U
                                             ^                        |
                                             +--- PID, inner loop <---+               R = F G D / K_i

G is the closed-loop response from currents, added where the synchronous control adds its demand, to displacements at
the sensors. D is the delay of the synchronous control, and F represents the sensors and the filter of the control. F, G
and D are evaluated at z = exp(j omega h).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amb_analysis.linear.components import harmonic_response
from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.linear.linearise import model_of
from amb_analysis.linear.sampled_loop import parameters_of_loop, sensor_response
from amb_analysis.machine.machine import Machine
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from array_types import Array, Complex
from signal_chain.presets import is_on

ROUNDING = 1e-9  # relative error of readings as a combination of the sensors


def sampled_receptance(machine: Machine, order: int = 1) -> Complex:
    """Return R of the loop with hold, controllers and sensors at a harmonic (m/N), complex, shape (n_sensors, n_axes).

    Forces are K_i I with the K_i that the controller assumes, which may differ from the K_i of the bearings.

    Raises
    ------
    ValueError
        If a bearing of the rotor has no sensor plane.
    """
    omega, parameters = order * machine.Omega, machine.parameters[CONTROLLER]
    added = list(_places_of_currents(machine).values())
    loop = model_of(machine.run_components, added, [f"{PLANT}.{sensor}" for sensor in machine.controlled.sensor_names])
    record = parameters_of_loop(machine.controlled, parameters)
    G = harmonic_response(loop, omega, loop.dt)
    if is_on(parameters["chain.preset"], parameters["chain.delay"]):
        G = G * np.exp(-1j * omega * parameters["sample_time"])
    return np.asarray(sensor_response(record, omega) @ G / _current_stiffnesses(machine))


def inner_response(machine: Machine, order: int = 1) -> Complex | None:
    """Return C of the controller u = -C q to whose demands the currents are added (`rolac_controller.inner_loop`).

    The result is None if the currents reach the magnetic bearings directly, or if the controller reads displacements
    that the sensors of the synchronous control do not measure.
    """
    source, added = machine.run_components, _places_of_currents(machine)
    system = source.plan.system
    inner = {target.partition(".")[0] for target in added.values()}
    if inner == {ACTUATOR}:
        return None
    (name,) = inner
    sensors = [f"{PLANT}.{sensor}" for sensor in machine.controlled.sensor_names]
    links = [link for link in system.connections if link.target.startswith(f"{name}.")]
    readings = {link.target: link.source for link in links if link.source.startswith(f"{PLANT}.")}
    combination = _combination(source, list(readings.values()), sensors)
    if combination is None:
        return None
    demands = [system.source_of(f"{ACTUATOR}.{axis}") or "" for axis in added]
    omega = order * machine.Omega
    model = model_of(source, [*added.values(), *readings], demands, components=(name,))
    part = harmonic_response(model, omega, model.dt)
    law = np.linalg.solve(part[:, : len(added)], part[:, len(added) :])  # before a delay, which both have
    measured = sensor_response(parameters_of_loop(machine.controlled, machine.parameters[CONTROLLER]), omega)
    return np.asarray(-_current_stiffnesses(machine)[:, None] * (law @ combination @ np.linalg.inv(measured)))


def _combination(source: LinearSource, readings: Sequence[str], sensors: Sequence[str]) -> Array | None:
    """Return T such that readings = T sensors, where both are outputs of the plant; None if no such T exists."""
    (plant,) = source.parts([PLANT])
    rows, values = (plant.selected(plant.inputs, names).law.C for names in (readings, sensors))
    T = rows @ np.linalg.pinv(values)
    return T if np.abs(T @ values - rows).max() <= ROUNDING * np.abs(rows).max() else None


def _places_of_currents(machine: Machine) -> dict[str, str]:
    """Return the inputs to which the controller sends currents, by name of the demand, such as `left.i_x`."""
    fed = {link.source: link.target for link in machine.prepared.assembly.system.connections}
    names = (f"{axis.bearing}.i_{axis.direction}" for axis in machine.controlled.axes)
    return {name: fed.get(f"{CONTROLLER}.{name}", f"{ACTUATOR}.{name}") for name in names}


def _current_stiffnesses(machine: Machine) -> Array:
    parameters = machine.parameters[CONTROLLER]
    return np.array([parameters[f"{axis.bearing}.k_i_{axis.direction}"] for axis in machine.controlled.axes])
