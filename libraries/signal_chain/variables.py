"""Variables of the signal chain: its parameters with their ranges, and inputs for sensor faults."""

from __future__ import annotations

from fmi_export.variables import Variable, enumerated, input_, parameter
from signal_chain.presets import IDEAL, PRESETS

FAULT_INPUTS = ("fault_dead", "fault_stuck", "fault_offset", "fault_noise")


def _switch(name: str, description: str) -> Variable:
    return parameter(name, "1", description, 0.0, type="Boolean")


def _count(name: str, description: str, start: int, minimum: int, maximum: int) -> Variable:
    return parameter(name, "1", description, start, minimum=minimum, maximum=maximum, type="Integer")


# Table 2.3 and section 2.4 of the thesis; cut-off, noise and seed are assumed.
CHAIN = (
    parameter("chain.preset", "1", "Effects that the signal chain includes", IDEAL, **enumerated(PRESETS)),
    _switch("chain.noise", "Whether the custom preset includes sensor noise"),
    _switch("chain.filter", "Whether the custom preset includes the anti-aliasing filter"),
    _switch("chain.adc", "Whether the custom preset includes the quantisation and range of the ADC"),
    _switch("chain.dac", "Whether the custom preset includes the quantisation and range of the DAC"),
    _switch("chain.delay", "Whether the custom preset includes a delay of the currents by one sample"),
    parameter(
        "chain.noise_rms",
        "m",
        "Standard deviation of the sensor noise",
        0.5e-6,
        minimum=0.0,
        maximum=1e-2,
        display_unit="um",
    ),
    _count("chain.seed", "Seed of the random numbers for the noise", 1, 0, 2**31 - 1),
    parameter(
        "chain.cutoff",
        "Hz",
        "Cut-off frequency of the anti-aliasing filter, a first-order low-pass",
        2000.0,
        minimum=0.1,
        maximum=1e6,
    ),
    parameter(
        "chain.sensitivity",
        "V/m",
        "Nominal voltage of the sensors per displacement",
        8000.0,
        minimum=1e-3,
        maximum=1e12,
    ),
    _count("chain.adc_bits", "Number of bits of the ADC", 16, 2, 32),
    parameter(
        "chain.adc_range",
        "V",
        "Largest magnitude of the voltage that the ADC converts",
        10.0,
        minimum=1e-6,
        maximum=1e6,
    ),
    _count("chain.dac_bits", "Number of bits of the DAC", 14, 2, 32),
    parameter(
        "chain.dac_range",
        "V",
        "Largest magnitude of the voltage that the DAC produces",
        10.0,
        minimum=1e-6,
        maximum=1e6,
    ),
    parameter(
        "chain.amplifier_gain", "A/V", "Current of the amplifiers per volt of the DAC", 0.5, minimum=1e-9, maximum=1e9
    ),
)


def sensor_faults(name: str, where: str) -> list[Variable]:
    """Declare the fault inputs of a signal's sensor, in the order of `FAULT_INPUTS`."""

    def fault(kind: str, unit: str, description: str, **options: object) -> Variable:
        return input_(f"{name}.fault_{kind}", unit, f"Fault: {description.format(where)}", field=kind, **options)

    return [
        fault("dead", "1", "the sensor {} reads 0", type="Boolean"),
        fault("stuck", "1", "the sensor {} keeps its last reading", type="Boolean"),
        fault("offset", "m", "offset of the sensor {}", minimum=-0.1, maximum=0.1, display_unit="um"),
        fault(
            "noise",
            "m",
            "standard deviation of additional noise of the sensor {}",
            minimum=0.0,
            maximum=0.1,
            display_unit="um",
        ),
    ]


def sensor_scale(name: str, where: str) -> list[Variable]:
    """Declare the scale of a signal's sensor."""
    description = f"Sensitivity of the sensor {where} relative to the nominal value"
    return [parameter(f"{name}.scale", "1", description, 1.0, minimum=0.0, maximum=1e3, field=".")]
