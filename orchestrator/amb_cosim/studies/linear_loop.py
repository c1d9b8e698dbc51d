"""Linear model of the levitated rotor with its sampled controllers, from the parameters of a co-simulation.

    e_k --->(+)--- I_k ---> z^-d ---> hold ---> amplifiers ---> K_i ---> rotor with K_s ---> sensors ---> x_k
             ^                                                                                             |
             +---------------------------------- PID of each axis <----------------------------------------+

The current I of an axis is that of its controller plus the injected current e; x is what its sensor shows, which need
not be in the plane of its bearing. With all loops closed I = S e, and the diagonal of S holds the sensitivities of the
axes as ISO 14839-3 defines them: 1/(1 + L) with the other loops closed. The control is decentralised: breaking a loop
at its sensor or at its current gives the same sensitivity.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import control
import numpy as np

from amb_actuator.interface import DYNAMIC
from amb_actuator.records import AXIS
from amb_cosim.design.magnetic_bearing import axis_parameters, operating_constants
from amb_cosim.design.rotor_models import control_loop
from amb_cosim.design.sampled_loop import axis_matrix, given_parameters
from amb_cosim.results.places import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.scenario.simulation import Prepared
from fmi_export.model import Array
from rolac_controller.control_loop import ControlLoop, LoopAxis
from rolac_controller.pid import damping, stiffness
from rolac_controller.records import Parameters
from rotor_analysis.assembly import assemble
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from signal_chain.lowpass import coefficients
from signal_chain.presets import is_on

NYQUIST = 1.0 - 1e-9  # of half the sample rate: python-control warns if rounding takes a frequency beyond it


@dataclass(frozen=True)
class LinearLoop:
    """Parameters, speed and rotor of the loop.

    parameters
        Values of the FMUs' parameters by component and name (SI).
    Omega
        Spin speed (rad/s).
    sample_time
        Time between samples of the controller (s).
    delay
        Samples between a displacement and the current that responds to it.
    rotor
        The packs' default without.
    passive
        Bearings that get no force of a magnet: nothing of the actuator is connected there.
    """

    parameters: Mapping[str, Mapping[str, float]]
    Omega: float
    sample_time: float
    delay: int = 0
    rotor: Rotor = field(default_factory=load_rotor)
    passive: frozenset[str] = frozenset()

    @cached_property
    def controlled(self) -> ControlLoop:
        """Bearings and sensor planes of the rotor, and how they belong together."""
        return control_loop(self.rotor)

    @property
    def axes(self) -> tuple[LoopAxis, ...]:
        """Axes of the bearings."""
        return self.controlled.axes

    @property
    def controller(self) -> Parameters:
        """Parameters of the controller, as kernels see them."""
        return given_parameters(self.controlled, self.parameters[CONTROLLER])

    def of_axis(self, component: str, axis: int, name: str) -> float:
        """Return a parameter of one axis: `k_s` of axis 3 is that of axis y of the second bearing."""
        bearing, direction, _ = self.axes[axis]
        return self.parameters[component][f"{bearing}.{name}_{direction}"]

    def bearing_axis(self, axis: int) -> np.record:
        """Return the parameters of the actuator of one axis, its own static current among them."""
        bearing, direction, _ = self.axes[axis]
        return axis_parameters(bearing, direction, **{n: self.of_axis(ACTUATOR, axis, n) for n in AXIS.names or ()})


def linear_loop(prepared: Prepared) -> LinearLoop:
    """Return the loop with the rotor and the parameters that a prepared run starts with.

    Raises
    ------
    ValueError
        If the run has no magnetic bearings or no controller of the models here.
    """
    parameters = {
        component: {name: value or 0.0 for name, value in values.items()}
        for component, values in prepared.plan.all_parameters(prepared.interfaces).items()
    }
    missing = [component for component in (PLANT, ACTUATOR, CONTROLLER) if component not in parameters]
    if missing:
        raise ValueError(f"scenario {prepared.name} has no component {missing[0]}; a linear loop needs one")
    controller = parameters[CONTROLLER]
    description = load_rotor(prepared.scenario.rotor)
    chain = given_parameters(control_loop(description), controller).own[0].chain
    delay = int(is_on(chain.preset, chain.delay))
    source_of = prepared.assembly.system.source_of
    passive = frozenset(b.name for b in description.bearings if source_of(f"{PLANT}.{b.name}.f_x") is None)
    return LinearLoop(parameters, prepared.plan.speed, controller["sample_time"], delay, description, passive)


def bearing_constants(loop: LinearLoop, axis: int) -> tuple[float, float]:
    """Return K_s (N/m) and K_i (N/A) of an axis at its operating point by the actuator's force law; 0 if passive."""
    if loop.axes[axis].bearing in loop.passive:
        return 0.0, 0.0
    return operating_constants(loop.bearing_axis(axis), int(loop.parameters[ACTUATOR]["force_law"]))


def rotor_system(loop: LinearLoop) -> control.StateSpace:
    """Return displacements (m) over coil currents (A): M q'' + (C + Omega G) q' + (K - B K_s B^T) q = B K_i I.

    Inputs in the order of the axes; outputs x and y of each sensor plane. The rotor is reduced as in its FMU.
    """
    description = loop.rotor
    full, reduction = assemble(description), reduced_rotor(description)
    model, outputs = reduction.model, reduction.right[full.rows(description.sensor_nodes)]
    for bearing in description.bearings:
        plant, name = loop.parameters[PLANT], bearing.name
        model = model.with_bearing(bearing.node, plant[f"{name}.k_b"] * np.eye(2), plant[f"{name}.c_b"] * np.eye(2))
    model = model.at(loop.Omega)
    n, n_axes, B = model.size, len(loop.axes), np.eye(model.size)[:, model.rows(description.bearing_nodes)]
    k_s, k_i = (np.diag(values) for values in zip(*(bearing_constants(loop, k) for k in range(n_axes)), strict=True))
    Minv = np.linalg.inv(model.M)
    A = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-Minv @ (model.K - B @ k_s @ B.T), -Minv @ (model.C + loop.Omega * model.G)],
        ]
    )
    force = np.vstack([np.zeros((n, n_axes)), Minv @ B @ k_i])
    return control.ss(A, force, np.hstack([outputs, np.zeros((len(outputs), n))]), np.zeros((len(outputs), n_axes)))


def amplifier_system(loop: LinearLoop) -> control.StateSpace:
    """Return coil currents over commanded currents: 1, or omega_b/(s + omega_b) for each axis."""
    n_axes = len(loop.axes)
    if loop.parameters[ACTUATOR]["amplifier"] != DYNAMIC:
        return control.ss([], [], [], np.eye(n_axes))
    omega = 2.0 * math.pi * np.diag([loop.of_axis(ACTUATOR, k, "bandwidth") for k in range(n_axes)])
    return control.ss(-omega, omega, np.eye(n_axes), np.zeros((n_axes, n_axes)))


def controller_system(loop: LinearLoop) -> control.StateSpace:
    """Return minus the demanded current of each axis (A) over what its sensor shows (m) (5.1 to 5.4).

    C(z) = z^-d F(z) PID(z)
    PID(z) = 1/K_i [ K_b + K_s + C_b (z - 1)/((tau + T) z - tau) + K_I T/(z - 1) ], F the filter before it, if any
    """
    time, controller = loop.sample_time, loop.controller
    own = controller.own[0]
    tau, chain, direct = own.derivative_time, own.chain, own.pid.direct
    delay_and_filter = control.tf([1.0], [1.0] + [0.0] * loop.delay, time)
    if is_on(chain.preset, chain.filter):
        decay, new = coefficients(chain.cutoff, time)
        delay_and_filter *= control.tf([new, 1.0 - decay - new], [1.0, -decay], time)
    laws = []
    for gains in controller.axes:
        c = float(damping(gains, direct))
        law = float(stiffness(gains, direct)) + control.tf([c, -c], [tau + time, -tau], time)
        if gains.k_integral != 0.0:
            law += control.tf([gains.k_integral * time], [1.0, -1.0], time)
        laws.append(control.ss(law * delay_and_filter / float(gains.k_i)))
    return control.append(*laws)


def sensitivity_system(loop: LinearLoop) -> control.StateSpace:
    """Return currents that reach the actuator over currents injected there, S = (1 + PID P)^-1, axes by axes.

    Raises
    ------
    ValueError
        If the closed loop is not stable; the sensitivity of an unstable loop cannot be measured.
    """
    sampled_plant = control.sample_system(rotor_system(loop) * amplifier_system(loop), loop.sample_time, "zoh")
    shown = control.ss([], [], [], axis_matrix(loop.controller), loop.sample_time) * sampled_plant
    closed = control.feedback(
        control.ss([], [], [], np.eye(len(loop.axes)), loop.sample_time), controller_system(loop) * shown
    )
    worst = max(closed.poles(), key=abs)
    if abs(worst) >= 1.0:
        raise ValueError(
            f"the loop is not stable: a vibration of {pole_frequency(worst, loop.sample_time):.1f} Hz grows by "
            f"{abs(worst) - 1.0:.2g} of itself with every sample; only a stable loop has a sensitivity"
        )
    return closed


def pole_frequency(pole: complex | Array, sample_time: float) -> float | Array:
    """Return the frequency (Hz) of the vibration of a discrete-time pole."""
    return np.abs(np.angle(pole)) / (2.0 * math.pi * sample_time)


def diagonal_response(system: control.StateSpace, frequencies: Array) -> Array:
    """Return the diagonal of a frequency response (complex), shape (axes, n), at frequencies (Hz), shape (n,).

    Frequencies above half the sample rate count as half the sample rate.
    """
    omega = 2.0 * math.pi * np.minimum(frequencies, NYQUIST * 0.5 / system.dt)
    full = control.frequency_response(system, omega, squeeze=False)
    values = full.magnitude * np.exp(1j * full.phase)
    return np.array([values[k, k] for k in range(len(values))])
