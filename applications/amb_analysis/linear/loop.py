"""The sampled loop of a levitated rotor under any controller: its sensitivities and its margins.

    e_k --->(+)--- i_k ---> hold, amplifiers ---> K_i ---> rotor with K_s ---> sensors ---(+)<--- n_j
             ^                                                                           | y_j
             +------------------------------- controller <-------------------------------+

With all loops closed, i = S e. The diagonal of S contains the sensitivities of the axes as ISO 14839-3 defines them:
1/(1 + L) with the other loops closed. In decentralised control, the sensitivities at the sensors equal the
sensitivities at the demands.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from amb_actuator.interface import axes_of
from amb_analysis.linear.aliasing import continuous_poles, logarithms
from amb_analysis.linear.axial_loop import AxialControl
from amb_analysis.linear.components import in_order, loop_of, without_idle_states
from amb_analysis.linear.linear_source import LinearSource
from amb_analysis.linear.stability import DRIFT, deciding_pole, eigensystem, stability_of
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.control_loop import exciting_components
from array_types import Array, Complex
from rotor_analysis.refinement import refined

if TYPE_CHECKING:
    from amb_analysis.linear.model import LinearModel  # imports python-control, which takes as long as a short run

CLOSE = 1e-5  # relative error of the largest growth rate
AT_REST = 1e-12  # displacement in an eigenvector of length 1 up to which the rotor is at rest in it, as in a filter's


@dataclass(frozen=True, eq=False)
class LoopPoles:
    """All poles of a sampled loop.

    z
        The poles, shape (n,).
    s
        The continuous poles (rad/s), where z = exp(s T); 0 for z = 0. Their frequencies are true even above half the
        sample rate (`amb_analysis.linear.aliasing`).
    shapes
        Displacements at the bearings for each pole, x and y of each bearing in turn, shape (2 bearings, n).
    stability
        The pole that determines stability.
    along
        Displacement of the thrust disc along the shaft for each pole, shape (n,); None if there is no disc.
    """

    z: Complex
    s: Complex
    shapes: Complex
    stability: LoopStability
    along: Complex | None = None

    @property
    def is_axial(self) -> NDArray[np.bool_]:
        """Whether the rotor moves along its shaft rather than across it, for each pole, shape (n,)."""
        return _is_axial(self.shapes, self.along)


@dataclass(frozen=True)
class Loop:
    """The sampled loop of a run.

    Raises
    ------
    ValueError
        If the run has no rotor, no magnetic bearings, or no controller that is connected to them.
    """

    linear_components: LinearSource
    _poles: dict[float, LoopPoles] = field(default_factory=dict, repr=False, compare=False)  # by speed (rad/s)

    def __post_init__(self) -> None:
        missing = [component for component in (PLANT, ACTUATOR) if component not in self.linear_components.names]
        if missing:
            raise ValueError(f"system {self.name} has no component {missing[0]}; a linear loop needs one")
        if not self.demands:
            raise ValueError(f"no demand of {ACTUATOR} is connected to a controller; a linear loop needs a controller")

    @property
    def name(self) -> str:
        """Name of the system."""
        return self.linear_components.plan.system.name

    @cached_property
    def components(self) -> list[str]:
        """The components of the loop, without those that only excite the rotor; these need no linear model."""
        exciting = exciting_components(self.linear_components.plan.system)
        return [name for name in self.linear_components.names if name not in exciting]

    @cached_property
    def axes(self) -> tuple[tuple[str, str], ...]:
        """Bearing and direction of each axis that has a magnet and a controller; the axis along the shaft is last."""
        source, layout = self.linear_components.plan.system.source_of, self.linear_components.layout(ACTUATOR)
        axes = axes_of(layout.get("bearings", ()), layout.get("thrust", ""))
        return tuple((b, a) for b, a in axes if source(f"{ACTUATOR}.{b}.i_{a}") and source(f"{PLANT}.{b}.f_{a}"))

    @property
    def lateral_axes(self) -> tuple[tuple[str, str], ...]:
        """The axes across the shaft, which come first in `axes`."""
        return tuple((b, a) for b, a in self.axes if a in "xy")

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of the axes, such as `bearing.x`."""
        return tuple(f"{b}.{a}" for b, a in self.axes)

    @property
    def demands(self) -> tuple[str, ...]:
        """Inputs of the actuator that receive the demanded currents (A)."""
        return tuple(f"{ACTUATOR}.{b}.i_{a}" for b, a in self.axes)

    @cached_property
    def sources(self) -> tuple[str, ...]:
        """Outputs of the controller that feed the demands."""
        return tuple(self.linear_components.plan.system.source_of(demand) or "" for demand in self.demands)

    @cached_property
    def readings(self) -> tuple[str, ...]:
        """Inputs of the controller that read displacements of the rotor (m), even if an FMU declares another unit."""
        controllers = {source.partition(".")[0] for source in self.sources}
        links = self.linear_components.plan.system.connections
        units = self.linear_components.units()
        return tuple(
            link.target
            for link in links
            if link.target.partition(".")[0] in controllers
            and link.source.startswith(f"{PLANT}.")
            and units[link.source] == "m"
        )

    @cached_property
    def sample_time(self) -> float:
        """Time between samples of the controller (s)."""
        controller = self.sources[0].partition(".")[0]
        sample_time = self.linear_components.parameters(controller).get("sample_time")
        if sample_time:
            return sample_time
        every = next(c.every for c in self.linear_components.plan.system.components if c.name == controller)
        return every * self.linear_components.plan.step_size

    @cached_property
    def late(self) -> float:
        """Fraction of a sample (1) by which the demands are late, in addition to whole samples."""
        controllers = dict.fromkeys(source.partition(".")[0] for source in self.sources)
        return max(part.late for part in self.linear_components.parts(list(controllers)))

    def poles(self, Omega: float) -> LoopPoles:
        """Return all poles at a spin speed (rad/s); they are computed once for each speed."""
        if Omega not in self._poles:
            self._poles[Omega] = self._poles_at(Omega)
        return self._poles[Omega]

    def _poles_at(self, Omega: float) -> LoopPoles:
        bearings = dict.fromkeys(bearing for bearing, _ in self.lateral_axes)
        names = [f"{bearing}.{axis}" for bearing in bearings for axis in "xy"]
        thrust = self.linear_components.layout(PLANT).get("thrust", "")
        displacements = [f"{PLANT}.{name}" for name in (*names, *([f"{thrust}.z"] if thrust else []))]
        source = self.linear_components.at(Omega)
        parts, feeds = in_order(source.parts(self.components), source.feeds(self.components), self.components)
        law = loop_of(parts, feeds).selected(self.demands[:1], displacements).law
        system = eigensystem(law.A)
        moved = np.asarray(law.C @ system.right, dtype=np.complex128)
        shapes, along = moved[: len(names)], moved[-1] if thrust else None
        stability, number = deciding_pole(law.A, system, self.sample_time)
        s = self._continuous(Omega, system.z, system.right, self.sample_time)
        omega = float(abs(s[number].imag))
        frequency = omega if omega > DRIFT * abs(stability.growth_rate) else 0.0
        is_axial = _is_axial(shapes, along)[number]
        place = f"{thrust}.z" if is_axial else _largest_place(names, np.abs(shapes[:, number]))
        stability = replace(stability, speed=Omega, frequency=frequency, place=place)
        return LoopPoles(system.z, s, shapes, stability, along)

    def _continuous(self, Omega: float, z: Complex, vectors: Complex, sample_time: float) -> Complex:
        """Return s of the poles z, determined from the rotor's states in the eigenvectors of the poles."""
        source = self.linear_components.at(Omega)
        parts, first, mass = source.parts(self.components), 0, source.mass(PLANT)
        lateral = 2 * len(mass)
        for part in parts:  # states of the continuous parts come first, in this order; along the shaft come last
            if lateral and part.outputs and part.outputs[0].startswith(f"{PLANT}."):
                states, A = vectors[first : first + lateral], part.law.A[:lateral, :lateral]
                return continuous_poles(z, sample_time, states, A, mass)
            first += len(part.law.A) if part.law.sample_time is None else 0
        return logarithms(z, sample_time)

    def least_stable(self, speeds: Sequence[float] | Array) -> LoopStability:
        """Return the stability at the least stable speed between the first and the last of ascending speeds (rad/s).

        Each maximum of the growth rate between these speeds is refined.
        """
        result: list[LoopStability] = []

        def growth_rates(more: Array) -> Array:
            result.extend(self.poles(float(Omega)).stability for Omega in more)
            return np.array([stability.growth_rate for stability in result[len(result) - len(more) :]])

        refined(growth_rates, np.asarray(speeds, dtype=float), lambda rates: rates, CLOSE, resonant=False)
        return max(result, key=lambda stability: stability.radius)

    def check_stable(self, speeds: Sequence[float] | Array) -> None:
        """Raise a ValueError if the loop is unstable between the first and the last of ascending speeds (rad/s)."""
        worst = self.least_stable(speeds)
        if not worst.is_stable:
            at = f"at {speed_unit().text(worst.speed)} {worst.motion}, |z| = {worst.radius:.7g}"
            raise ValueError(f"the loop is not stable: {at}; only a stable loop has a steady response")

    @cached_property
    def axial_control(self) -> AxialControl | None:
        """The control of the axis along the shaft; None if there is no such axis.

        Raises
        ------
        ValueError
            If the demand of this axis depends on other displacements, or on the speed.
        """
        along = [k for k, (_, axis) in enumerate(self.axes) if axis == "z"]
        if not along:
            return None
        demand, source = self.sources[along[0]], self.linear_components.plan.system.source_of
        name = demand.partition(".")[0]
        read = [reading for reading in self.readings if reading.startswith(f"{name}.")]
        of_axis = [reading for reading in read if source(reading) == f"{PLANT}.{self.axis_names[along[0]]}"]
        others = [reading for reading in read if reading not in of_axis]
        controls = []
        for Omega in self.linear_components.table_speeds() or [0.0]:
            (part,) = self.linear_components.at(Omega).parts([name])
            coupled = without_idle_states(part.selected(others, [demand]).law)
            if len(of_axis) != 1 or len(coupled.A) or coupled.D.any():
                raise ValueError(
                    f"{demand} depends on more than the displacement along the shaft ({', '.join(of_axis)})"
                )
            law = without_idle_states(part.selected(of_axis, [demand]).law)
            late = self.linear_components.samples_late(part, self.demands[along[0]])
            controls.append(AxialControl(law, self.sample_time, late))
        if any(control.differs_from(controls[0]) for control in controls):
            raise ValueError(
                f"{demand} depends on the speed; the control law along the shaft must be the same at all speeds"
            )
        return controls[0]

    @cached_property
    def closed(self) -> LinearModel:
        """The closed loop, from signals injected at the demands and readings to the resulting demands and readings."""
        from amb_analysis.linear.linearise import model_of

        ends = (*self.demands, *self.readings)
        return model_of(self.linear_components, ends, ends, self.components)

    def sensitivity(self) -> LinearModel:
        """Return the sensitivity S = (1 + L)^-1 of all axes, the ratio of demanded to injected currents.

        Raises
        ------
        ValueError
            If the closed loop is unstable; the sensitivity of an unstable loop cannot be measured.
        """
        from amb_analysis.linear.linearise import model_of

        model = model_of(self.linear_components, self.demands, self.demands, self.components)
        check_stable(model)
        return model


def _is_axial(shapes: Complex, along: Complex | None) -> NDArray[np.bool_]:
    """Return, for each pole, whether motion along the shaft exceeds motion across it at every bearing, shape (n,)."""
    if along is None:
        return np.zeros(shapes.shape[1], dtype=bool)
    return np.asarray(np.abs(along) > np.maximum(np.abs(shapes).max(axis=0, initial=0.0), AT_REST))


def _largest_place(names: Sequence[str], sizes: Array) -> str:
    """Return the axis with the largest motion, or its bearing if the other axis there moves at least half as much."""
    if not sizes.max(initial=0.0) > 0.0:
        return ""
    top = int(sizes.argmax())
    return names[top] if sizes[top ^ 1] < 0.5 * sizes[top] else names[top].rpartition(".")[0]


def check_stable(model: LinearModel) -> None:
    """Raise a ValueError if a sampled model is unstable."""
    worst = stability_of(model.A, model.dt)
    if not worst.is_stable:
        raise ValueError(
            f"the loop is not stable: {worst.motion}, |z| = 1 + {worst.radius - 1.0:.2g}; only a stable loop has a "
            "sensitivity"
        )


def pole_frequency(pole: complex | Array | Complex, sample_time: float) -> float | Array:
    """Return the vibration frequency (Hz) of a discrete-time pole."""
    return np.abs(np.angle(pole)) / (2.0 * math.pi * sample_time)
