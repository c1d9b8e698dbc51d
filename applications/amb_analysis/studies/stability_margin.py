"""Study of the levitated rotor's stability margin (ISO 14839-3), both computed and measured in a co-simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, ClassVar, Literal

import numpy as np

from amb_analysis.linear.loop import Loop
from amb_analysis.linear.responses import diagonal_response, disk_gain_and_phase, disk_margin, response
from amb_analysis.machine.casing_damping import damping_taken
from amb_analysis.machine.machine import Machine
from amb_analysis.studies.injection import HIGHEST, LOWEST, measure, plan_measurement, waiting_samples
from amb_analysis.studies.inputs import Number, controlled, spin_speed
from amb_analysis.studies.result import MachineResult
from amb_analysis.studies.sensitivity_curves import peaks_of, sensitivity_bands
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.cosim.system.values import Raw, quantity
from amb_cosim.presentation.text_tables import TextBlock, labelled_table, text_table
from amb_cosim.presentation.units import speed_unit
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import Scenario
from amb_files.checks import require
from amb_files.plain_values import plain_values
from array_types import Array, Complex
from rotor_analysis.refinement import refined
from signal_chain.presets import is_on

ZONES = {"A": 3.0, "B": 4.0, "C": 5.0}  # upper limit of |S| in each zone; zone D has none
SLOWEST, SLOW = 1e-3, 40  # Hz; number of frequencies from there to the first of the curves
CONTRADICTION = 0.1  # of S; coupling in steps explains 1 % at sharp peaks, nonlinear magnets 1 % at a peak of 12
CASING = {
    "all planes move alike": 1.0,
    "only the magnets move": 0.0,
}  # motion of sensors and seals over that of the magnets
CASING_TITLE = "Modal mass times damping ratio (kg) that a mode of the casing needs"
CASING_POINTS = 400  # frequencies
CASING_ROWS = (10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0)  # Hz, of the table
COMPARED = 500.0  # Hz, up to which computed and measured sensitivity are compared


@dataclass(frozen=True)
class PeakBeyond:
    """Largest |S| (1) above the frequency range of ISO 14839-3, up to half the sample rate, and its frequency (Hz)."""

    peak: float
    frequency: Annotated[float, "Hz"]


@dataclass(frozen=True, eq=False)
class AxisSensitivity:
    """Sensitivity of an axis.

    peak, peak_frequency, zone
        Largest computed |S| (1) up to the 2 kHz of the standard, its frequency (Hz), and its zone.
    S
        1/(1 + L) at the frequencies of the study (1), complex, shape (n,).
    measured_frequencies, measured
        Frequencies (Hz) and |S| there (1) in the co-simulation, shape (lines,).
    measured_peak
        Largest |S| in the co-simulation, also between these frequencies (`peak_between_lines`).
    largest_difference_below_500_hz, largest_difference
        Largest |S_measured/S_computed - 1| (1) up to 500 Hz, and at all measured frequencies. Both values of S belong
        to the rotor of the co-simulation, which has all modes up to half the sample rate.
    beyond
        The peak above 2 kHz; None if half the sample rate is 2 kHz or less.
    """

    peak: float
    peak_frequency: Annotated[float, "Hz"]
    zone: str
    S: Complex
    measured_frequencies: Annotated[Array, "Hz"]
    measured: Array
    measured_peak: float
    largest_difference_below_500_hz: float
    largest_difference: float
    beyond: PeakBeyond | None = None

    @property
    def computed(self) -> Array:
        """|S| at the frequencies of the study (1), shape (n,)."""
        return np.abs(self.S)

    @property
    def L(self) -> Complex:
        """Loop gain 1/S - 1 (1) with the loops of the other axes closed, shape (n,); the critical point is -1."""
        return np.asarray(1.0 / self.S - 1.0)


@dataclass(frozen=True, eq=False)
class GangOfFour:
    """Largest singular values over the frequencies of the study, each of shape (n,).

    S, T
        S = (1 + L)^-1 and T = L (1 + L)^-1 (1), with the loops broken at the demanded currents.
    PS
        Response of the measured displacements to disturbance currents (m/A).
    CS
        Response of the demanded currents to sensor disturbances (A/m).
    """

    S: Array
    T: Array
    PS: Annotated[Array, "m/A"]
    CS: Annotated[Array, "A/m"]


@dataclass(frozen=True, eq=False)
class DiskMargin:
    """Changes of gain and phase, simultaneous and independent in all loops, under which the system stays stable.

    alpha
        Lower bound of the disk margin over the frequencies of the study (1), shape (n,).
    least, frequency
        Smallest alpha (1) between 0 Hz and half the sample rate, and its frequency (Hz).
    gain, phase
        Factor by which each gain may be multiplied or divided (1), and angle by which each phase may be shifted (deg).
    """

    alpha: Array
    least: float
    frequency: Annotated[float, "Hz"]
    gain: float
    phase: Annotated[float, "deg"]


@dataclass(frozen=True, eq=False)
class CasingDamping:
    """Damping that a mode of the casing needs, so that the loop does not make it unstable (`machine.casing_damping`).

    frequencies
        Natural frequencies of the mode (Hz), shape (n,).
    needed
        Least product (kg) of the mode's damping ratio and its modal mass for a displacement of 1 at the magnets, by
        shape of the mode, each of shape (n,); negative where the loop damps the mode.
    """

    frequencies: Annotated[Array, "Hz"]
    needed: Annotated[dict[str, Array], "kg"]

    def worst(self, shape: str) -> tuple[float, float]:
        """Return the largest product (kg) that is needed with a shape, and its frequency (Hz)."""
        k = int(self.needed[shape].argmax())
        return float(self.needed[shape][k]), float(self.frequencies[k])

    @property
    def conclusion(self) -> str:
        """Sentence on the damping that a mode of the casing needs."""
        needs = []
        for shape in self.needed:
            needed, at = self.worst(shape)
            needs.append(f"{needed:.3g} kg at {at:.0f} Hz if {shape}" if needed > 0.0 else f"nothing if {shape}")
        return (
            "a mode of the casing that this model leaves out must have a modal mass times damping ratio above "
            + ", and ".join(needs)
        )

    def text(self) -> list[TextBlock]:
        """Return the conclusion, and a table of the needed products."""
        table = text_table(CASING_TITLE, ("at (Hz)", *self.needed))
        for row in self.rows:
            table.add_row(*row)
        return [self.conclusion, table]

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The needed products (kg) at some frequencies, as text."""
        shown = [hertz for hertz in CASING_ROWS if hertz <= self.frequencies[-1]]
        return [
            (f"{hertz:g}", *(_needed(np.interp(hertz, self.frequencies, curve)) for curve in self.needed.values()))
            for hertz in shown
        ]


def _needed(product: float) -> str:
    return f"{product:.3g}" if product > 0.0 else "none"


@dataclass(frozen=True, eq=False, repr=False)
class StabilityMargin(MachineResult):
    """Sensitivities of all axes, and the disk margins of all loops together.

    speed
        Spin speed (rad/s).
    sample_time
        Sample time of the controller (s).
    delay
        Delay of the currents in samples.
    amplifier
        Amplifier model.
    settings
        Changed parameters, as `component.variable=value`.
    zone_limits
        Upper limit of |S| (1) in zones A to C.
    frequencies
        Frequencies of the computed curves (Hz), up to half the sample rate, shape (n,).
    axes
        Sensitivity of each axis, by name.
    gang_of_four
        Largest singular values of S, T, PS and CS.
    disk_margins
        Margins of all loops at once, with the loops broken at the demanded `currents` or at the `sensors`.
    casing
        Damping that modes of the casing need; None if it was not computed.
    """

    name: ClassVar[str] = "sensitivity"

    speed: Annotated[float, "rad/s"]
    sample_time: Annotated[float, "s"]
    delay: Annotated[float, "samples"]
    amplifier: Literal["dynamic", "ideal"]
    settings: tuple[str, ...]
    zone_limits: dict[str, float]
    frequencies: Annotated[Array, "Hz"]
    axes: dict[str, AxisSensitivity]
    gang_of_four: GangOfFour
    disk_margins: dict[str, DiskMargin]
    casing: CasingDamping | None = None

    def text(self) -> list[TextBlock]:
        """Return tables of the peaks and the disk margins, and the zone of the largest peak."""
        headings = ("peak of |S|", "at (Hz)", "zone", "measured differs below 500 Hz (%)", "anywhere (%)")
        table = labelled_table(f"{self.rotor}: sensitivity at {speed_unit().text(self.speed)}", "axis", *headings)
        for name, axis in self.axes.items():
            differences = (100.0 * axis.largest_difference_below_500_hz, 100.0 * axis.largest_difference)
            table.add_row(
                name,
                f"{axis.peak:.3f}",
                f"{axis.peak_frequency:.1f}",
                axis.zone,
                *(f"{difference:.3f}" for difference in differences),
            )
        name, worst = max(self.axes.items(), key=lambda item: item[1].peak)
        answer = (
            f"Zone {worst.zone}: the largest peak of |S| at {speed_unit().text(self.speed)} is {worst.peak:.3f} at "
            f"{worst.peak_frequency:.1f} Hz ({name})"
        )
        all_loops = text_table(self._all_frequencies, ("broken at", "disk margin", "at (Hz)", "gain", "phase (deg)"))
        for place, margin in self.disk_margins.items():
            numbers = (f"{margin.least:.3f}", f"{margin.frequency:.1f}", f"{margin.gain:.3f}", f"{margin.phase:.1f}")
            all_loops.add_row(place, *numbers)
        lines = ["zones of ISO 14839-3: A below 3, B below 4, C below 5"]
        above = [(axis.beyond, name) for name, axis in self.axes.items() if axis.beyond is not None]
        if above:
            largest, name = max(above, key=lambda item: item[0].peak)
            lines.append(
                f"above {HIGHEST:g} Hz, beyond the range of the standard, the largest peak is {largest.peak:.3f} at "
                f"{largest.frequency:.1f} Hz ({name})"
            )
        return [answer, table, all_loops, *lines, *(self.casing.text() if self.casing else ()), *self.warning_lines()]

    @property
    def _all_frequencies(self) -> str:
        return f"All loops at once, at all frequencies up to half the sample rate, {0.5 / self.sample_time:.5g} Hz"


def zone(peak: float) -> str:
    """Return the zone of a peak of |S|: A below 3, B below 4, C below 5, otherwise D (ISO 14839-3)."""
    return next((name for name, limit in ZONES.items() if peak < limit), "D")


def _check_agreement(axes: Sequence[str], frequencies: Array, computed: Complex, measured: Complex) -> None:
    """Raise a ValueError if measured and computed S differ by more than `CONTRADICTION`; one of them is then wrong."""
    difference = np.abs(measured / computed - 1.0)
    k, line = divmod(int(difference.argmax()), difference.shape[1])
    if difference[k, line] > CONTRADICTION:
        values = (
            f"{abs(measured[k, line]):.3g} in the co-simulation and {abs(computed[k, line]):.3g} in the linear model"
        )
        raise ValueError(
            f"the linear model contradicts the co-simulation: at {frequencies[k, line]:.1f} Hz, |S| of {axes[k]} is "
            f"{values}; an FMU of your own may be nonlinear, or its sample time may differ from the communication step"
        )


def peak_between_lines(peak: float, frequency: float, lines: Array, measured: Complex, ratios: Complex) -> float:
    """Return the largest measured |S|, either at a line or at the computed peak, which may lie between two lines.

    At the computed peak, the measured |S| is estimated as the computed |S| times the ratio of measured to computed S.
    This ratio varies slowly from line to line.

    Parameters
    ----------
    peak, frequency
        Largest computed |S|, and its frequency (Hz).
    lines, measured, ratios
        Frequencies (Hz), measured S, and the ratio of measured to computed S, each of shape (n,).
    """
    ratio = np.interp(frequency, lines, ratios.real) + 1j * np.interp(frequency, lines, ratios.imag)
    return max(peak * float(np.abs(ratio)), float(np.abs(measured).max()))


def sensitivity(
    scenario: str | Path | Scenario | None = None,
    *,
    rotor: str | Path | None = None,
    controller: str | Path | None = None,
    speed: Number | None = None,
    amplifier: bool = False,
    delay: bool = False,
    sample_time: Number | None = None,
    set: Mapping[str, Raw] | None = None,
    flavour: Flavour = "native",
) -> StabilityMargin:
    """Compute |S| of each axis over frequency, measure it in a co-simulation, and return the peaks and zones.

    The sensitivity of an axis is S = 1/(1 + L), with the loops of the other axes closed (ISO 14839-3). The study also
    computes the largest singular values of S, T, PS and CS, and the disk margins of all loops at once
    (`linear.loop.disk_margin`). Curves begin at 1 Hz and end at half the sample rate; measured curves and the zones end
    at 2 kHz.

    Parameters
    ----------
    scenario, rotor, controller
        The machine with its parameters, its rotor and its controller, as for `studies.inputs.controlled`. Inputs and
        events of the scenario are not used.
    speed
        Spin speed (rad/s), or a string with its unit; by default the speed of the scenario.
    amplifier
        Whether the amplifiers have a bandwidth and a voltage limit even if the scenario's have none.
    delay
        Whether currents are delayed by one sample even if the scenario's currents are not.
    sample_time
        Sample time of the controller (s), or a string with its unit; by default the sample time of the scenario.
    set, flavour
        Parameter values by `component.variable`, as numbers or strings with units, and the flavour of the FMUs.

    Raises
    ------
    ValueError
        If a value is not allowed, the loop is not stable, or the co-simulation is not linear.

    Examples
    --------
    >>> result = sensitivity("compressor_levitated")
    >>> [f"{axis.peak:.2f} {axis.zone}" for axis in result.axes.values()]
    ['1.74 A', '1.74 A', '1.84 A', '1.84 A']
    """
    values = controlled(scenario, rotor, controller)
    if speed is not None:
        values = values.model_copy(update={"Omega": spin_speed(speed)})
    settings = plain_values(set, "set")
    if sample_time is not None:
        time = quantity(sample_time, "s", "sample_time")
        require(0.0 < time < 0.5 / LOWEST, "sample_time", f"{time:g} s", f"> 0 s and < {0.5 / LOWEST:g} s")
        settings[f"{CONTROLLER}.sample_time"] = time
        values = values.model_copy(update={"communication_step": time})
    options = RunOptions(flavour=flavour)
    prepared = plan_measurement(values, settings, amplifier, delay, options)
    machine = Machine(prepared)
    loop, parameters = machine.loop, machine.parameters
    system = loop.sensitivity()
    of_run = Loop(machine.run_components).sensitivity()
    measured = measure(prepared, waiting_samples(of_run, float(of_run.dt)))
    (below, up_to_the_limit), *above = sensitivity_bands(system)
    beyond = [PeakBeyond(*peak) for band in above for peak in peaks_of(*band)]
    frequencies = np.concatenate([below, *(hertz[1:] for hertz, _ in above)])
    curves = np.concatenate([up_to_the_limit, *(S[:, 1:] for _, S in above)], axis=1)
    expected = np.array([diagonal_response(of_run, row)[k] for k, row in enumerate(measured.frequencies)])
    ratios = measured.sensitivity / expected
    difference = np.abs(ratios - 1.0)
    _check_agreement(loop.axis_names, measured.frequencies, expected, measured.sensitivity)
    axes = {
        name: AxisSensitivity(
            peak=peak,
            peak_frequency=frequency,
            zone=zone(peak),
            S=curves[k],
            measured_frequencies=measured.frequencies[k],
            measured=np.abs(measured.sensitivity[k]),
            measured_peak=peak_between_lines(
                peak, frequency, measured.frequencies[k], measured.sensitivity[k], ratios[k]
            ),
            largest_difference_below_500_hz=float(difference[k][measured.frequencies[k] < COMPARED].max()),
            largest_difference=float(difference[k].max()),
            beyond=beyond[k] if beyond else None,
        )
        for k, (name, (peak, frequency)) in enumerate(
            zip(loop.axis_names, peaks_of(below, up_to_the_limit), strict=True)
        )
    }
    gang, disks = _all_loops(loop, frequencies)
    return StabilityMargin(
        scenario=values.name,
        rotor=machine.rotor.name,
        speed=prepared.speed,
        sample_time=loop.sample_time,
        delay=_delay(parameters[CONTROLLER]),
        amplifier="dynamic" if parameters[ACTUATOR]["amplifier"] else "ideal",
        settings=tuple(f"{name}={value}" for name, value in plain_values(set, "set").items()),
        zone_limits=dict(ZONES),
        frequencies=frequencies,
        axes=axes,
        gang_of_four=gang,
        disk_margins=disks,
        casing=casing_damping(machine),
        warnings=prepare_run(values.machine(), settings, options=options).warnings,
    )


def casing_damping(machine: Machine) -> CasingDamping:
    """Return the damping that modes of the casing need from 1 Hz up to 2 kHz or half the sample rate."""
    frequencies = np.geomspace(LOWEST, min(HIGHEST, 0.5 / machine.loop.sample_time), CASING_POINTS)
    return CasingDamping(
        frequencies, {shape: damping_taken(machine, frequencies, psi) for shape, psi in CASING.items()}
    )


def _all_loops(loop: Loop, frequencies: Array) -> tuple[GangOfFour, dict[str, DiskMargin]]:
    """Return the four sensitivities and the disk margins at frequencies (Hz).

    Minima of the margins are also located between these frequencies, and between 0 Hz and the lowest frequency.
    """
    n = len(loop.demands)

    def values(more: Array) -> Array:
        closed = response(loop.closed, more)
        S, CS, PS, S_sensors = closed[:n, :n], closed[:n, n:], closed[n:, :n], closed[n:, n:]
        T = np.eye(n)[:, :, None] - S
        return np.stack([disk_margin(S), disk_margin(S_sensors), *map(_largest, (S, T, PS, CS))], axis=1)

    slower = np.append(0.0, np.geomspace(SLOWEST, frequencies[0], SLOW, endpoint=False))
    closer, refined_values = refined(values, np.append(slower, frequencies), lambda rows: 1.0 / rows[:, :2])
    at_frequencies = np.isin(closer, frequencies)
    margins = zip(("currents", "sensors"), refined_values.T[:2], strict=True)
    return GangOfFour(*refined_values[at_frequencies, 2:].T), {
        place: DiskMargin(
            alpha[at_frequencies],
            float(alpha.min()),
            float(closer[alpha.argmin()]),
            *disk_gain_and_phase(float(alpha.min())),
        )
        for place, alpha in margins
    }


def _largest(matrices: Complex) -> Array:
    return np.asarray(np.linalg.norm(np.moveaxis(matrices, -1, 0), 2, axis=(1, 2)))


def _delay(parameters: Mapping[str, float | None]) -> float:
    """Return the delay of a controller's demands, in samples, from the controller's parameters."""
    chain = is_on(parameters.get("chain.preset") or 0.0, parameters.get("chain.delay") or 0.0)
    return float(chain) + (parameters.get("delay") or 0.0)
