"""Study of one axis of a magnetic bearing: constants away from the centre, linear range, load capacity, slew rate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar

import numpy as np

from amb_actuator.force import pull
from amb_actuator.interface import axes_of
from amb_analysis.machine import axis_capability
from amb_analysis.machine.machine import machine_of
from amb_analysis.studies.inputs import Number, positive
from amb_analysis.studies.result import DrawnResult, WarnedResult
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.model_constants import magnetic_bearing
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.results.component_names import ACTUATOR, PLANT
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.rotors import RotorSource
from amb_cosim.scenario.scenario import Scenario, as_scenario
from amb_files.suggestions import suggest
from array_types import Array
from rolac_controller.control_loop import LoopAxis
from rotor_analysis.rotor_file import load_rotor

TOLERANCE = 0.05  # of the linear law
EDGE = 1e-3  # share of the air gap beyond the map, if no retainer limits the motion
POINTS = 61  # in each direction of a map
LOADS = np.linspace(0.0, 1.0 - 1e-6, 61)  # share of the largest static load, at which the current is at its limit
FREQUENCIES = np.geomspace(1.0, 1e4, 121)  # Hz
AMPLITUDES = (0.25, 0.5, 1.0)  # of the largest sine of the control current


@dataclass(frozen=True)
class FullSwing:
    """Amplitude of a sinusoidal control current (A), amplitude of its force (N), and bandwidth (Hz) at this current."""

    i_c: Annotated[float, "A"]
    force: Annotated[float, "N"]
    bandwidth: Annotated[float, "Hz"]


@dataclass(frozen=True, eq=False)
class ForceBandwidth:
    """Largest sinusoidal force (N) at the centre that the voltage allows, as a function of frequency (Hz)."""

    frequencies: Annotated[Array, "Hz"]
    force_amplitude: Annotated[Array, "N"]


@dataclass(frozen=True)
class StaticLoad:
    """Static load (N) of the axis at its static current, and remaining control force (N) against and along the load."""

    static_load: Annotated[float, "N"]
    up: Annotated[float, "N"]
    down: Annotated[float, "N"]


@dataclass(frozen=True, eq=False)
class LoadCurves:
    """Remaining control force as a function of the static load.

    static_load
        Static loads (N), shape (n,).
    static_current
        Static current (A) that carries each load.
    up, down
        Largest control force (N) against and along each load.
    own
        Static load and remaining control force at the static current of the axis.
    """

    static_load: Annotated[Array, "N"]
    static_current: Annotated[Array, "A"]
    up: Annotated[Array, "N"]
    down: Annotated[Array, "N"]
    own: StaticLoad


@dataclass(frozen=True, eq=False)
class OperatingMap:
    """K_s, K_i and the error of the linear law as functions of displacement and control current.

    x, i_c
        Displacements up to the retainer (m), shape (m,), and control currents (A), shape (n,).
    k_s, k_i
        Negative stiffness (N/m) and current stiffness (N/A), shape (n, m).
    linear_error
        Error of the linear law, divided by |K_s x| + |K_i I_c| (1), shape (n, m).
    """

    x: Annotated[Array, "m"]
    i_c: Annotated[Array, "A"]
    k_s: Array
    k_i: Array
    linear_error: Array


@dataclass(frozen=True, eq=False, repr=False)
class BearingAxis(WarnedResult, DrawnResult):
    """Capabilities of an axis of a magnetic bearing.

    axis
        Name of the axis: its bearing and direction.
    bias_current, static_current
        Bias and static currents of the coils (A).
    k_s, k_i
        Negative stiffness (N/m) (2.8) and current stiffness (N/A) (2.9) at the centre.
    tolerance
        Error of the linear law (1) at the limits of the linear range.
    linear_range
        Range in which the linear law holds.
    slew_rate
        Fastest rise and fastest fall of the force (N/s).
    amplifier_bandwidth
        Bandwidth of the amplifier for small signals (Hz).
    full_swing
        Three sinusoidal control currents of ascending amplitude; the last is the largest possible.
    bandwidth
        Largest sinusoidal force as a function of frequency.
    load
        Remaining control force as a function of the static load.
    map
        K_s, K_i and the error of the linear law as functions of displacement and control current.
    """

    name: ClassVar[str] = "linearisation"

    axis: str
    bias_current: Annotated[float, "A"]
    static_current: Annotated[float, "A"]
    k_s: Annotated[float, "N/m"]
    k_i: Annotated[float, "N/A"]
    tolerance: float
    linear_range: axis_capability.LinearRange
    slew_rate: Annotated[tuple[float, float], "N/s"]
    amplifier_bandwidth: Annotated[float, "Hz"]
    full_swing: tuple[FullSwing, ...]
    bandwidth: ForceBandwidth
    load: LoadCurves
    map: OperatingMap

    def text(self) -> list[TextBlock]:
        """Return a table with a row for each property."""
        (x_low, x_high), (i_low, i_high) = self.linear_range.x, self.linear_range.i_c
        (rise, fall), at_static_current = self.slew_rate, self.load.own
        sines = (f"{number(s.i_c)} A ({number(s.force)} N) to {number(s.bandwidth)} Hz" for s in self.full_swing)
        rows = {
            "K_s, K_i (2.8, 2.9)": f"{number(1e-3 * self.k_s)} N/mm, {number(self.k_i)} N/A",
            f"linear law within {self.tolerance:.0%}": (
                f"x from {number(1e3 * x_low)} to {number(1e3 * x_high)} mm, "
                f"I_c from {number(i_low)} to {number(i_high)} A"
            ),
            "slew rate of the force": f"{number(1e-6 * rise)} MN/s up, {number(1e-6 * fall)} MN/s down",
            "bandwidth": f"{self.amplifier_bandwidth:g} Hz; at the voltage limit {', '.join(sines)}",
            "control force left": (
                f"{number(at_static_current.up)} N up, {number(at_static_current.down)} N down, "
                f"in addition to a static load of {number(at_static_current.static_load)} N"
            ),
        }
        title = f"{self.axis}, {self.bias_current:g} A bias and {self.static_current:g} A static current"
        table = text_table(title, ("property", "value"), rows.items(), left=("property", "value"))
        table.show_header = False
        return [table, *self.warning_lines()]


def linearisation(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: RotorSource = None,
    axis: str | None = None,
    bias_current: Number | None = None,
    static_current: Number | None = None,
    set: Mapping[str, Raw] | None = None,
) -> BearingAxis:
    """Return K_s(x, I_c), K_i(x, I_c), linear range, load capacity, slew rate and bandwidth of a bearing axis.

    Parameters
    ----------
    scenario
        Name of a packaged scenario, or a TOML file, that defines the machine and its parameters. By default, the start
        values of the actuator are used.
    rotor
        Name of a packaged rotor, or a rotor file, to use instead of the scenario's.
    axis
        Bearing and direction, such as `left.x` or `thrust.z`; the first axis by default.
    bias_current
        Bias current of the coils (A), or a string with its unit; it replaces the value of the axis.
    static_current
        Current (A) that carries the static load, or a string with its unit; it replaces the value of the axis.
    set
        Parameter values by `component.variable`, as numbers or strings with units; they require a scenario.

    Raises
    ------
    ValueError
        If no such axis exists, or if the bias and static currents do not allow control currents of both signs.

    Examples
    --------
    >>> axis = linearisation("compressor_levitated")
    >>> f"{axis.k_s / 1e3:.0f} N/mm, {axis.k_i:.0f} N/A"
    '12952 N/mm, 1107 N/A'
    """
    chosen, parameters, clearance, warnings = _axis_of(scenario, rotor, axis, set or {})
    currents: dict[str, float] = {}
    if bias_current is not None:
        currents["bias_current"] = positive(bias_current, "A", "bias_current")
    if static_current is not None:
        currents["static_current"] = quantity(static_current, "A", "static_current")
    p = magnetic_bearing.axis_parameters(chosen.bearing, chosen.direction, **(parameters | currents))
    largest = float(axis_capability.current_amplitude(p, 0.0))
    if not largest > 0.0:
        raise ValueError(
            f"bias_current = {p.bias_current:g} A with static_current = {p.static_current:g} A is not allowed; a coil "
            f"carries 0 to {p.current_limit:g} A, and the control current must be able to raise and lower its current"
        )
    k_s, k_i = magnetic_bearing.linear_constants(p)
    full_swing = tuple(
        FullSwing(i, float(_force_amplitude(p, i)), axis_capability.full_swing_bandwidth(p, i))
        for i in (share * largest for share in AMPLITUDES)
    )
    return BearingAxis(
        axis=chosen.name,
        bias_current=float(p.bias_current),
        static_current=float(p.static_current),
        k_s=k_s,
        k_i=k_i,
        tolerance=TOLERANCE,
        linear_range=axis_capability.linear_range(p, TOLERANCE),
        slew_rate=axis_capability.force_slew_rate(p),
        amplifier_bandwidth=float(p.bandwidth),
        full_swing=full_swing,
        bandwidth=ForceBandwidth(FREQUENCIES, _force_amplitude(p, axis_capability.current_amplitude(p, FREQUENCIES))),
        load=_load_capacity(p),
        map=_operating_map(p, clearance),
        warnings=warnings,
    )


def _axis_of(
    scenario: str | Path | Scenario | None, rotor: RotorSource, axis: str | None, settings: Mapping[str, Raw]
) -> tuple[LoopAxis, dict[str, float], float, tuple[str, ...]]:
    """Return an axis, its parameters (a scenario's, if there is one), the rotor's reach along it (m), and warnings.

    The reach is the smallest clearance of the bearing's retainers or, along the shaft, of the faces. The reach never
    exceeds the air gap, because the force law holds only within the gap.
    """
    if scenario is None and settings:
        raise ValueError(f"{next(iter(settings))} is set without a scenario; name the scenario that it belongs to")
    machine = None
    description = load_rotor(rotor)
    values: Mapping[str, float] = {}
    if scenario is not None:
        chosen = as_scenario(as_scenario(scenario).machine(), rotor)
        machine = machine_of(prepare_run(chosen, settings), ACTUATOR)
        description, values = machine.rotor, machine.parameters[PLANT]
    bearings = [bearing.name for bearing in description.bearings]
    axes = [LoopAxis(bearing, direction, "") for bearing, direction in axes_of(bearings, description.thrust)]
    names = [loop_axis.name for loop_axis in axes]
    if axis is not None and axis not in names:
        raise ValueError(f"axis = {axis} is not allowed; {suggest(axis, names)}")
    k = 0 if axis is None else names.index(axis)
    record = None if machine is None else machine.axis(axes[k].bearing, axes[k].direction)
    parameters = {} if record is None else {name: float(record[name]) for name in record.dtype.names or ()}
    of_bearing = [site for site in description.sites if site.bearing == axes[k].bearing]
    retainers = description.faces if axes[k].direction == "z" else of_bearing
    gap = float(magnetic_bearing.axis_parameters(axes[k].bearing, axes[k].direction, **parameters).gap)
    clearances = [values.get(f"{site.name}.clearance", site.clearance) for site in retainers]
    warnings = () if machine is None else machine.prepared.warnings
    return axes[k], parameters, min([*clearances, (1.0 - EDGE) * gap]), warnings


def _force_amplitude(p: np.record, i_c: Array | float) -> Array:
    """Return the force amplitude (N) at the centre for a sinusoidal control current (A), with saturation."""
    return 0.5 * (
        magnetic_bearing.linearisation(p, 0.0, i_c).force
        - magnetic_bearing.linearisation(p, 0.0, -np.asarray(i_c)).force
    )


def _load_capacity(p: np.record) -> LoadCurves:
    """Return the remaining control force as a function of the static load, with its value at the static current."""

    def carried(static: float) -> float:
        return float(pull(p, p.bias_current + static, p.gap).force - pull(p, p.bias_current, p.gap).force)

    static_load, loads = carried(p.static_current), LOADS * carried(p.current_limit - p.bias_current)
    capacity, at_static = (axis_capability.load_capacity(p, each) for each in (loads, np.array([static_load])))
    return LoadCurves(loads, *capacity, StaticLoad(static_load, float(at_static.up[0]), float(at_static.down[0])))


def _operating_map(p: np.record, clearance: float) -> OperatingMap:
    """Return K_s, K_i and the error of the linear law for control currents and displacements up to a clearance (m)."""
    x, i_c = np.linspace(-clearance, clearance, POINTS), np.linspace(*magnetic_bearing.current_range(p), POINTS)
    slopes = magnetic_bearing.linearisation(p, x[None, :], i_c[:, None])
    error = axis_capability.linear_error(p, x[None, :], i_c[:, None])
    return OperatingMap(x, i_c, slopes.k_s, slopes.k_i, error)
