"""The sensitivities of the four axes measured: a co-simulation of the three FMUs with multi-sines injected.

Each axis has current added to what its controller demands, through `command_voltage` of the actuator. The lines of the
four axes interleave, so that one run measures all of them: at a line of one axis nothing is injected into the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from amb_actuator.interface import AXES, N_AXES
from amb_cosim.plan import SPEED, parse_settings
from amb_cosim.scenario import make_scenario
from amb_cosim.simulation import Prepared, prepare, run_prepared
from amb_cosim.studies.loop import loop_of
from fmi_export.model import Array
from rolac_controller.names import CUSTOM

PERIOD = 4.0  # s: lines every 0.25 Hz, every 1 Hz for each axis
LOWEST, HIGHEST = 1.0, 2000.0  # Hz
PEAK = 0.05  # A, of what is injected: it moves the rig by some 20 um and takes no amplifier to its voltage limit
STEPS_OF_A_SAMPLE = 4  # with dynamic amplifiers: the coupling then errs by less than a percent near the sharpest peaks
SUBSTEP = 31.25e-6  # s, of the plant's own integration
REMAINDER = 1e-6  # of the transient, when the measurement begins
LONGEST = 60.0  # s
INPUTS = tuple(f"amb_actuator.{bearing}.command_voltage_{axis}" for bearing, axis in AXES)


@dataclass(frozen=True)
class Measurement:
    """Sensitivity of each axis (complex) at its own frequencies (Hz), both of shape (axes, lines)."""

    frequencies: Array
    sensitivity: NDArray[np.complex128]


def prepared_loop(speed: float, sample_time: float, amplifier: bool, delay: bool, settings: list[str]) -> Prepared:
    """The levitated rotor without unbalance, ready to run; with `delay` the currents come a sample late.

    Dynamic amplifiers are coupled at steps shorter than a sample.
    """
    steps = STEPS_OF_A_SAMPLE if amplifier else 1
    scenario = make_scenario(
        {
            "description": "Levitated rotor with injected currents",
            "Omega": speed,
            "settle_cycles": 0,
            "end_time": sample_time,
            "communication_step": sample_time / steps,
            "inputs": {"amb_actuator": {"*.command_voltage_?": 0.0}},
            "parameters": {
                "amb_actuator": {"amplifier": int(amplifier), "mean_current": True},
                "rolac_controller": {"sample_time": sample_time, "chain.preset": CUSTOM, "chain.delay": delay},
                "rotor_contact": {"solver.max_substep": SUBSTEP},
            },
            "record": {
                "variables": ["rolac_controller.mb?.i_?", "amb_actuator.*clipped*", "amb_actuator.*limited*"],
            },
        },
        "sensitivity",
    )
    prepared = prepare(scenario, parse_settings(settings))
    changed = [name for name, value in prepared.plan.inputs.items() if name != SPEED and value != 0.0]
    if changed:
        raise ValueError(f"{changed[0]} cannot be set here; only parameters can, so that currents alone move the rotor")
    if prepared.plan.system.component("rolac_controller").every != steps:
        raise ValueError("rolac_controller.sample_time cannot be set here; --sample-time sets it for the whole loop")
    return prepared


def schroeder_phases(powers: Array) -> Array:
    """Phases (rad) that give a sum of neighbouring harmonics a low peak: -2 pi sum_{m<i} (i - m) P_m  (5.11 to 5.14).

    Parameters
    ----------
    powers
        Relative power of each harmonic, with the sum 1, shape (n,).
    """
    return -2.0 * math.pi * np.concatenate([[0.0], np.cumsum(np.cumsum(powers))[:-1]])


def multi_sines(samples: int, sample_time: float) -> tuple[Array, NDArray[np.intp]]:
    """One period of what is injected into each axis (A), shape (axes, samples), and its lines, harmonics of the period.

    All lines of an axis have the same power, and the peak is `PEAK`.
    """
    highest = min(HIGHEST, 0.5 / sample_time)
    first, count = round(LOWEST * samples * sample_time), math.ceil(highest * samples * sample_time)
    lines = np.arange(first, first + (count - first) // N_AXES * N_AXES).reshape(-1, N_AXES).T
    phases = schroeder_phases(np.full(lines.shape[1], 1.0 / lines.shape[1]))
    spectrum = np.zeros((N_AXES, samples // 2 + 1), dtype=complex)
    np.put_along_axis(spectrum, lines, np.exp(1j * phases)[None, :], axis=1)
    signals = np.fft.irfft(spectrum, samples, axis=1)
    return PEAK * signals / np.abs(signals).max(axis=1, keepdims=True), lines


def settling_samples(decay: float, sample_time: float) -> int:
    """Samples until a transient is over that keeps the share `decay` of itself from one sample to the next.

    Raises
    ------
    ValueError
        If that takes too long to be simulated.
    """
    samples = math.ceil(math.log(REMAINDER) / math.log(decay))
    if samples * sample_time > LONGEST:
        raise ValueError(
            f"transients keep {decay:.6f} of themselves from sample to sample, and would take "
            f"{samples * sample_time:.0f} s to die out; a measurement waits no longer than {LONGEST:g} s"
        )
    return samples


def measure(prepared: Prepared, decay: float) -> Measurement:
    """Co-simulate with the multi-sines, discard the transient, and compare currents over one period.

    Parameters
    ----------
    prepared
        From `prepared_loop`.
    decay
        Magnitude of the loop's slowest pole.

    Raises
    ------
    ValueError
        If the run fails, or is not that of a linear rotor without contact.
    """
    plan, loop = prepared.plan, loop_of(prepared)
    steps = round(loop.sample_time / plan.step_size)
    samples = 2 * round(0.5 * PERIOD / loop.sample_time)
    settling = settling_samples(decay, loop.sample_time)
    injected, lines = multi_sines(samples, loop.sample_time)
    gains = [loop.of_axis("amb_actuator", axis, "amplifier_gain") for axis in range(N_AXES)]
    if not all(gains):
        raise ValueError("amplifier_gain = 0 A/V is not allowed; it must not be 0, since currents are injected by it")
    last = settling + samples
    volts = injected / np.array(gains)[:, None]
    events = tuple(
        (n * steps, name, float(volts[k, n % samples])) for n in range(last) for k, name in enumerate(INPUTS)
    )
    result = run_prepared(replace(prepared, plan=replace(plan, last=last * steps, events=events)))
    if result.outcome.failure is not None:
        raise ValueError(result.outcome.failure)
    _check_linear(result.dataset)
    first = settling + 1  # what the controller gives to the actuator at a sample is seen after it
    demanded = [result.dataset[f"rolac_controller.{b}.i_{a}"].values[::steps] for b, a in AXES]
    currents = np.array(demanded)[:, first : first + samples]
    at = np.arange(settling, settling + samples) % samples
    ratio = _lines(currents, lines) / _lines(injected[:, at], lines)
    return Measurement(lines / (samples * loop.sample_time), 1.0 + ratio)


def _lines(signals: Array, lines: NDArray[np.intp]) -> NDArray[np.complex128]:
    return np.take_along_axis(np.fft.rfft(signals, axis=1), lines, axis=1)


def _check_linear(dataset: xr.Dataset) -> None:
    """Raise a ValueError if the rotor touched or an amplifier came to a limit."""
    happened: Mapping[str, str] = {
        "rotor_contact.contact_state": "the rotor touched its retainer",
        **{f"amb_actuator.{b}.clipped_{a}": f"the current of {b}.{a} was clipped" for b, a in AXES},
        **{
            f"amb_actuator.{b}.voltage_limited_{a}": f"the amplifier of {b}.{a} was at its voltage limit"
            for b, a in AXES
        },
    }
    for name, what in happened.items():
        if dataset[name].values.any():
            raise ValueError(f"{what} during the measurement, which must be that of a linear system")
