"""Receptance that the controller would identify, from the linear model of the loop, whatever closes it.

    U --> u = Re[U exp(j theta)]/K_i --> D --(+)--> currents --> machine --> displacements --> F --> Q = R U
                                             ^                        |
                                             +--- PID, inner loop <---+               R = F G D / K_i

G is the response of the closed loop from currents that are added where those of the synchronous control arrive to the
displacements at its sensors, D its delay, F its sensors and filter; all at z = exp(j omega h).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from amb_cosim.design.sampled_loop import given_parameters, sensor_response
from amb_cosim.linear.linearisable import LinearSource, of_prepared
from amb_cosim.linear.linearise import model_of
from amb_cosim.linear.model import LinearModel
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.simulation import PlannedRun
from amb_cosim.studies.machine import Machine, machine_of
from signal_chain.presets import is_on

Complex = NDArray[np.complex128]

ROUNDING = 1e-9  # relative; of a displacement that is a combination of others


def sampled_receptance(prepared: PlannedRun, order: int = 1) -> Complex:
    """Return R of a harmonic, shape (n_sensors, n_axes), complex (m/N), of the loop with hold, controllers and sensors.

    The forces are those that the controller assumes, K_i I with its own K_i; the bearings have theirs.

    Raises
    ------
    ValueError
        If a bearing of the rotor has no sensor plane.
    """
    machine, made = machine_of(prepared, CONTROLLER), of_prepared(prepared)
    omega, parameters = order * machine.Omega, machine.parameters[CONTROLLER]
    added = list(_places_of_currents(made, machine).values())
    loop = model_of(made, added, [f"{PLANT}.{sensor}" for sensor in machine.controlled.sensor_names])
    local = given_parameters(machine.controlled, parameters)
    G = _response(loop, omega)
    if is_on(parameters["chain.preset"], parameters["chain.delay"]):
        G = G * np.exp(-1j * omega * parameters["sample_time"])
    return np.asarray(sensor_response(local, omega) @ G / _current_stiffnesses(machine))


def inner_response(prepared: PlannedRun, order: int = 1) -> Complex | None:
    """Return C of a controller to whose demands the currents are added, u = -C q (`rolac_controller.inner_loop`).

    None where the currents reach the magnetic bearings as they are, or that controller reads displacements that the
    sensors of the synchronous control do not tell.
    """
    machine, made = machine_of(prepared, CONTROLLER), of_prepared(prepared)
    added, system = _places_of_currents(made, machine), made.assembly.system
    inner = {target.partition(".")[0] for target in added.values()}
    if inner == {ACTUATOR}:
        return None
    (name,) = inner
    local = [f"{PLANT}.{sensor}" for sensor in machine.controlled.sensor_names]
    links = [link for link in system.connections if link.target.startswith(f"{name}.")]
    readings = {link.target: link.source for link in links if link.source.startswith(f"{PLANT}.")}
    displayed = _combination(made, list(readings.values()), local)
    if displayed is None:
        return None
    demands = [system.source_of(f"{ACTUATOR}.{axis}") or "" for axis in added]
    omega = order * machine.Omega
    part = _response(model_of(made, [*added.values(), *readings], demands, components=(name,)), omega)
    law = np.linalg.solve(part[:, : len(added)], part[:, len(added) :])  # before a delay, which both have
    measured = sensor_response(given_parameters(machine.controlled, machine.parameters[CONTROLLER]), omega)
    return np.asarray(-_current_stiffnesses(machine)[:, None] * (law @ displayed @ np.linalg.inv(measured)))


def _combination(made: LinearSource, readings: Sequence[str], sensors: Sequence[str]) -> NDArray[np.float64] | None:
    """Return T of readings = T sensors, outputs of the plant; None if they are no combinations of these."""
    (plant,) = made.parts([PLANT])
    rows, values = (plant.selected(plant.inputs, names).law.C for names in (readings, sensors))
    T = rows @ np.linalg.pinv(values)
    return T if np.abs(T @ values - rows).max() <= ROUNDING * np.abs(rows).max() else None


def _places_of_currents(made: LinearSource, machine: Machine) -> dict[str, str]:
    """Return the inputs that the currents of the controller feed, by the actuator's name of the demand, `left.i_x`."""
    fed = {link.source: link.target for link in made.assembly.system.connections}
    names = (f"{axis.bearing}.i_{axis.direction}" for axis in machine.controlled.axes)
    return {name: fed.get(f"{CONTROLLER}.{name}", f"{ACTUATOR}.{name}") for name in names}


def _current_stiffnesses(machine: Machine) -> NDArray[np.float64]:
    parameters = machine.parameters[CONTROLLER]
    return np.array([parameters[f"{axis.bearing}.k_i_{axis.direction}"] for axis in machine.controlled.axes])


def _response(model: LinearModel, omega: float) -> Complex:
    """Return C (z 1 - A)^-1 B + D at z = exp(j omega h)."""
    z = np.exp(1j * omega * model.dt)
    return np.asarray(model.C @ np.linalg.solve(z * np.eye(model.nstates) - model.A, model.B) + model.D)
