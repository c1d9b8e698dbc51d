"""Measurement of the sensitivities of all axes in a co-simulation with injected multi-sines.

A current is added to each demand of the controller through the actuator's `command_voltage`, with the same delay as the
demand. The spectral lines of the axes interleave, so that one run measures all axes: at a line of one axis, no current
is injected in the other axes. If another component, such as a force generator, excites the rotor, its contribution to
the currents is measured in a run without injection and subtracted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eig

from amb_actuator.interface import DYNAMIC
from amb_analysis.linear.components import StateSpace
from amb_analysis.linear.loop import Loop
from amb_analysis.linear.stability import stability_of
from amb_analysis.machine.machine import HIGHEST as MODES_TO
from amb_analysis.machine.machine import Machine
from amb_cosim.cosim.fmu.fmus import model_of
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.cosim.system.experiment import Plan
from amb_cosim.cosim.system.values import Raw
from amb_cosim.results.component_names import ACTUATOR, CONTROLLER, PLANT
from amb_cosim.results.contact_history import in_contact
from amb_cosim.results.stability import SOURCES
from amb_cosim.scenario.plan import IDEAL, ScenarioPlan
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import SPEED, Scenario
from amb_cosim.scenario.simulation import execute
from array_types import Array, Complex, Indices
from rotor_analysis.reduced_rotor import with_modes_up_to
from signal_chain.presets import CUSTOM, is_on

PERIOD = 4.0  # s: lines every 0.25 Hz, for each of four axes every 1 Hz, of five every 1.25 Hz
LOWEST, HIGHEST = 1.0, 2000.0  # Hz
INJECTED = 1e-3  # of the bias current: the nonlinear law then adds 0.7 % to a line at a peak of 12, with 0.01 7 %
STEPS_OF_A_SAMPLE = 4  # with dynamic amplifiers or parts of a sample of delay: the error is below 1 % at sharp peaks
SUBSTEP = 31.25e-6  # s, of the plant's integration
LIMITS = ("clipped", "voltage_limited")  # outputs of an axis of the actuator
REMAINDER = 1e-6  # share of the transient that remains when the measurement begins
LONGEST = 60.0  # s, of the wait for that


@dataclass(frozen=True)
class MeasuredSensitivity:
    """Spectral lines (Hz) of each axis, and the complex sensitivity at these lines, both of shape (axes, lines)."""

    frequencies: Array
    sensitivity: Complex


def plan_measurement(
    scenario: Scenario,
    settings: Mapping[str, Raw],
    amplifier: bool = False,
    delay: bool = False,
    options: RunOptions = DEFAULTS,
) -> ScenarioPlan:
    """Return a prepared run of a scenario's machine, levitated without unbalance.

    The rotor has all modes up to half the sample rate, even if its file states a stronger reduction, because fewer
    modes would change the sensitivity. The controller's signal chain retains its delay and filter; noise and converters
    are off, because they are not linear.

    Parameters
    ----------
    scenario, settings
        The scenario of the machine, and values by `component.variable` that replace the scenario's.
    amplifier
        Whether the amplifiers are dynamic even if the scenario's are not; dynamic amplifiers are coupled in steps
        shorter than a sample.
    delay
        Whether currents are delayed by one sample even if the scenario's are not.
    options
        Options of the run; only the flavour of the FMUs is used.

    Raises
    ------
    ValueError
        If a value is not allowed, an input is set, or the scenario has no magnetic bearings.
    """
    values: dict[str, dict[str, Raw]] = {ACTUATOR: {"mean_current": True}, PLANT: {"solver.max_substep": SUBSTEP}}
    values[CONTROLLER] = {} if "chain.preset" in scenario.parameters.get(CONTROLLER, {}) else {"chain.preset": CUSTOM}
    base = scenario.machine(parameters=values)
    first = prepare_run(base, settings, options=options)
    machine = Machine(first)
    loop, parameters = machine.loop, machine.parameters
    dynamic = amplifier or parameters[ACTUATOR]["amplifier"] == DYNAMIC
    linear = _linear_chain(parameters[CONTROLLER], delay)
    sample_time = loop.sample_time
    measuring = base.changed(
        rotor=with_modes_up_to(machine.rotor, max(MODES_TO, math.pi / sample_time)),
        description="Levitated rotor with injected currents",
        end_time=sample_time,
        communication_step=sample_time / (STEPS_OF_A_SAMPLE if dynamic or loop.late > 0.0 else 1),
        coupling="gauss_seidel",
        inputs={ACTUATOR: {"*.command_voltage_?": 0.0}},
        record={
            "variables": [
                *loop.sources,
                *(f"{ACTUATOR}.{bearing}.{name}_{axis}" for bearing, axis in loop.axes for name in LIMITS),
            ],
        },
    )
    changed = {f"{CONTROLLER}.{name}": value for name, value in linear.items()}
    prepared = prepare_run(measuring, {**settings, f"{ACTUATOR}.amplifier": int(dynamic), **changed}, options=options)
    steady_inputs = (SPEED, f"{PLANT}.{IDEAL}")
    disturbing = [name for name, value in prepared.inputs.items() if name not in steady_inputs and value != 0.0]
    if disturbing:
        raise ValueError(
            f"{disturbing[0]} cannot be set here; only parameters can be set, so that only the injected currents "
            "move the rotor"
        )
    return _with_steps_of_the_run(prepared, first)


def _with_steps_of_the_run(prepared: ScenarioPlan, run: Plan) -> ScenarioPlan:
    """Return the prepared measurement with foreign FMUs stepped as they are in the run of the scenario.

    A foreign controller may take a sample whenever it is stepped, so shorter steps would change its law.
    """
    ratio = max(1, round(run.step_size / prepared.step_size))
    every = {c.name: c.every * ratio for c in run.system.components if model_of(c.fmu) is None}
    components = tuple(replace(c, every=every.get(c.name, c.every)) for c in prepared.system.components)
    system = replace(prepared.system, components=components)
    return replace(prepared, system=system)


def _linear_chain(parameters: Mapping[str, float], delay: bool) -> dict[str, Raw]:
    """Return the settings that leave only the linear part of a controller's signal chain, if it has one."""
    if "chain.preset" not in parameters:
        if delay:
            raise ValueError(f"delay is not allowed; {CONTROLLER} has no signal chain")
        return {}
    preset = parameters["chain.preset"]
    return {
        "chain.preset": CUSTOM,
        "chain.delay": delay or bool(is_on(preset, parameters["chain.delay"])),
        "chain.filter": bool(is_on(preset, parameters["chain.filter"])),
        **dict.fromkeys(("chain.noise", "chain.adc", "chain.dac"), False),
    }


def schroeder_phases(powers: Array) -> Array:
    """Return phases (rad) for which a sum of adjacent harmonics has a low peak.

    phi_i = -2 pi sum_{m<i} (i - m) P_m     (5.11 to 5.14)

    Parameters
    ----------
    powers
        Relative power of each harmonic, shape (n,); the powers add up to 1.
    """
    return -2.0 * math.pi * np.concatenate([[0.0], np.cumsum(np.cumsum(powers))[:-1]])


def multi_sines(n_axes: int, samples: int, sample_time: float) -> tuple[Array, Indices]:
    """Return one period of the injected currents, shape (axes, samples), and the harmonics of each axis.

    All harmonics of an axis have the same power, and each current has a peak of 1.
    """
    highest = min(HIGHEST, 0.5 / sample_time)
    first, count = round(LOWEST * samples * sample_time), math.ceil(highest * samples * sample_time)
    lines = np.arange(first, first + (count - first) // n_axes * n_axes).reshape(-1, n_axes).T
    phases = schroeder_phases(np.full(lines.shape[1], 1.0 / lines.shape[1]))
    spectrum = np.zeros((n_axes, samples // 2 + 1), dtype=complex)
    np.put_along_axis(spectrum, lines, np.exp(1j * phases)[None, :], axis=1)
    signals = np.fft.irfft(spectrum, samples, axis=1)
    return signals / np.abs(signals).max(axis=1, keepdims=True), lines


def settling_samples(decay: float, sample_time: float, remainder: float = REMAINDER) -> int:
    """Return the number of samples that a transient with the factor `decay` per sample takes to fall to `remainder`.

    Raises
    ------
    ValueError
        If this takes longer than `LONGEST`.
    """
    samples = math.ceil(math.log(remainder) / math.log(decay))
    if samples * sample_time > LONGEST:
        raise ValueError(
            f"transients shrink by the factor {decay:.6f} per sample and would take "
            f"{samples * sample_time:.0f} s to die out; the limit is {LONGEST:g} s"
        )
    return samples


def waiting_samples(loop: StateSpace, sample_time: float) -> int:
    """Return the number of samples after which no transient of a loop disturbs a measurement.

    A drift z that is slower than the lowest line begins with an amplitude of at most a (1) if the sines have an
    amplitude of 1. Until the drift has died out, it distorts each line of a spectrum computed from N samples by at most
    the fraction (2). Some lags of eddy currents take minutes to decay, but they hardly affect the spectrum, so they
    need not die out. All other transients must die out.

        a = |C x| |y^H B|/|y^H x| sum 1/|exp(j omega) - z|                                  (1)
        share = 2 a (1 - z^N)/(N |exp(j omega_1) - z|)                                      (2)

    Here, x and y are the right and left eigenvectors, the sum is over all lines omega, and omega_1 is the lowest line
    (rad per sample).

    Raises
    ------
    ValueError
        If this takes longer than `LONGEST`.
    """
    A, B, C = (np.asarray(matrix, np.float64) for matrix in (loop.A, loop.B, loop.C))
    z, left, right = eig(A, left=True, right=True)
    count, highest = PERIOD / sample_time, min(HIGHEST, 0.5 / sample_time)
    omega = 2.0 * np.pi * sample_time * np.arange(LOWEST, highest, 1.0 / PERIOD)
    is_drift = (z.imag == 0.0) & (z.real > math.exp(-omega[0])) & (z.real < 1.0)
    stability = stability_of(A, sample_time)
    others = np.abs(z[~is_drift & (np.abs(z) <= stability.radius)])
    samples = settling_samples(float(others.max(initial=0.0)), sample_time) if (others > 0.0).any() else 0
    for k in np.flatnonzero(is_drift):
        drift, x, y = float(z[k].real), right[:, k].real, left[:, k].real
        a = np.abs(C @ x).max() * np.abs(y @ B).max() / abs(y @ x) * np.sum(1.0 / np.abs(np.exp(1j * omega) - drift))
        share = 2.0 * a * (1.0 - drift**count) / (count * abs(np.exp(1j * omega[0]) - drift))
        if share > REMAINDER and drift <= stability.radius:
            samples = max(samples, settling_samples(drift, sample_time, REMAINDER / min(share, 1.0)))
    return samples


def measure(plan: ScenarioPlan, waiting: int) -> MeasuredSensitivity:
    """Return the sensitivities from one period of a co-simulation with the multi-sines, after the transient.

    Parameters
    ----------
    plan
        Run from `plan_measurement`.
    waiting
        Number of samples before the measurement (see `waiting_samples`).

    Raises
    ------
    ValueError
        If the run fails, the rotor touches a site, or an amplifier reaches a limit.
    """
    machine = Machine(plan)
    loop, parameters = machine.loop, machine.parameters[ACTUATOR]
    steps = round(in_steps(loop.sample_time, plan.step_size))
    samples = 2 * round(in_steps(0.5 * PERIOD, loop.sample_time))
    sines, lines = multi_sines(len(loop.axes), samples, loop.sample_time)
    gains, biases = (
        np.array([parameters[f"{b}.{name}_{a}"] for b, a in loop.axes]) for name in ("amplifier_gain", "bias_current")
    )
    if not gains.all() or not biases.all():
        what = "bias_current = 0 A" if gains.all() else "amplifier_gain = 0 A/V"
        raise ValueError(
            f"{what} is not allowed; it must not be 0: the injected voltage is a share of bias_current / amplifier_gain"
        )
    injected = INJECTED * biases[:, None] * sines
    last = waiting + samples + 1
    volts = injected / gains[:, None]
    inputs = [f"{ACTUATOR}.{b}.command_voltage_{a}" for b, a in loop.axes]
    shares = share_of_new(loop.late, steps)
    events = tuple(
        (n * steps + j, name, float(volts[k, n % samples] * share + volts[k, (n - 1) % samples] * (1.0 - share)))
        for n in range(last)
        for j, share in shares.items()
        for k, name in enumerate(inputs)
    )
    first = waiting * steps + max(shares) + 1  # the record has a step's demand at its end

    def demanded(events: tuple[tuple[int, str, float], ...]) -> tuple[Array, bool]:
        """Return the demands of a run with injected currents, and whether another component also excites the rotor."""
        result = execute(replace(plan, last=last * steps, events=events))
        if result.outcome.failure is not None:
            raise ValueError(result.outcome.failure)
        _check_linear(result.signals, loop)
        demands = np.array([result.signals[source].values[first::steps] for source in loop.sources])
        return demands[:, :samples], SOURCES in result.signals.attrs

    currents, excited = demanded(events)
    if excited:
        currents = currents - demanded(())[0]
    recorded = np.arange(waiting, waiting + samples) % samples
    ratio = _spectrum(currents, lines) / _spectrum(injected[:, recorded], lines)
    return MeasuredSensitivity(lines / (samples * loop.sample_time), 1.0 + ratio)


def share_of_new(late: float, steps: int) -> dict[int, float]:
    """Return the steps of a sample in which a delayed demand takes effect, and the new demand's weight in each.

    Parameters
    ----------
    late
        Delay as a fraction of a sample, from 0 to 1.
    steps
        Number of communication steps in a sample.
    """
    first = math.floor(late * steps)
    share = first + 1 - late * steps
    return {first: 1.0} if share == 1.0 else {first: share, first + 1: 1.0}


def _spectrum(signals: Array, lines: Indices) -> Complex:
    """Return the spectrum of each signal at its lines, shape (axes, lines)."""
    return np.take_along_axis(np.fft.rfft(signals, axis=1), lines, axis=1)


def _check_linear(dataset: Signals, loop: Loop) -> None:
    """Raise a ValueError if the rotor touched anything or an amplifier reached a limit."""
    touching = in_contact(dataset)
    violations = [("the rotor touched a retainer or another site", touching is not None and touching.any())]
    for b, a in loop.axes:
        clipped, limited = (dataset[f"{ACTUATOR}.{b}.{name}_{a}"].values.any() for name in LIMITS)
        violations += [(f"the current of {b}.{a} was clipped", clipped)]
        violations += [(f"the amplifier of {b}.{a} was at its voltage limit", limited)]
    for violation, happened in violations:
        if happened:
            raise ValueError(f"{violation} during the measurement, which requires a linear system")
