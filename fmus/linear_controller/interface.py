"""Variable table of the controller, derived from its signals, demands and states."""

from __future__ import annotations

from fmi_export.interface import Interface, interface, repeated
from fmi_export.variables import FAULT, Array, Variable, input_, output, parameter
from linear_controller.ports import Ports
from signal_chain.variables import CHAIN, FAULT_INPUTS, sensor_faults, sensor_scale

MAX_DELAY = 32.0  # samples
NO_LIMIT = 1e9  # A
LARGEST_SPEED = 1e5  # rad/s, 955,000 rpm: beyond the bursting speed of any rotor of this kind
ROUNDING = 1e-9  # relative; a sample time converted from another unit has rounding


def _common_parameters(sample_time: float) -> list[Variable]:
    return [
        parameter(
            "sample_time",
            "s",
            "Time between samples, for which the matrices hold and which is also the longest allowed communication "
            "step",
            sample_time,
            minimum=(1.0 - ROUNDING) * sample_time,
            maximum=(1.0 + ROUNDING) * sample_time,
        ),
        parameter(
            "delay",
            "1",
            "Delay of the demands in samples, possibly fractional, in addition to chain.delay",
            0.0,
            minimum=0.0,
            maximum=MAX_DELAY,
        ),
        parameter(
            "start_at_rest",
            "1",
            "Whether the first sample starts with filters settled under the present signals and integrators at zero, "
            "instead of all states at zero",
            1.0,
            type="Boolean",
        ),
        parameter(
            "transfer_time",
            "s",
            "Time constant with which the jump of a demand at switch-on or reset fades, or 0 to let the demand jump",
            0.01,
            minimum=0.0,
            maximum=1e3,
        ),
    ]


def _signal(name: str) -> list[Variable]:
    return [
        input_(name, "m", f"Measured signal {name}", minimum=-0.1, maximum=0.1, field="measured", display_unit="um"),
        input_(
            f"{name}.setpoint",
            "m",
            f"Setpoint of the measured signal {name}",
            minimum=-0.1,
            maximum=0.1,
            display_unit="um",
        ),
    ]


def _demand_parameters(name: str) -> list[Variable]:
    def tunable(field: str, unit: str, description: str, start: float) -> Variable:
        bounds = {"minimum": -1e12, "maximum": 1e12, "tunable": True}
        return parameter(f"{name}.{field}", unit, f"{description} {name}", start, **bounds)

    return [
        tunable("gain", "1", "Gain of the law for the demand", 1.0),
        tunable("offset", "A", "Offset that is added to the demand", 0.0),
        tunable("lower", "A", "Lower limit of the demand", -NO_LIMIT),
        tunable("upper", "A", "Upper limit of the demand", NO_LIMIT),
    ]


def _feedforward(name: str) -> list[Variable]:
    return [
        input_(
            f"{name}.feedforward",
            "A",
            f"Feedforward that is added to the demand {name}",
            minimum=-1e6,
            maximum=1e6,
            field=".",
        )
    ]


# What the demands at the start depend on, in addition to the matrices.
_START = (
    *("start_at_rest", "Omega", "enable", "reset", "scales[*]", "signals[*].measured", "signals[*].setpoint"),
    *("faults[*].dead", "faults[*].stuck", "faults[*].offset", "chain.preset", "chain.adc", "chain.sensitivity"),
    *("chain.adc_range", "chain.adc_bits"),
)
_DAC = ("chain.preset", "chain.dac", "chain.dac_bits", "chain.dac_range", "chain.amplifier_gain")


def _demand_output(name: str, reached: tuple[str, ...]) -> list[Variable]:
    common = tuple(f"{name}.{field}" for field in ("gain", "offset", "lower", "upper", "feedforward"))
    start = (*_START, *common, *_DAC)
    depends_on = (*reached, f"{name}.feedforward")
    return [output(name, "A", f"Demanded current {name}", depends_on=depends_on, initially_depends_on=start, field=".")]


def _state(number: int, reached: tuple[str, ...]) -> list[Variable]:
    return [
        output(
            f"state.x{number}",
            "1",
            f"State number {number} in the coordinates of the original matrices",
            depends_on=reached,
            initially_depends_on=_START,
            field=".",
        )
    ]


def interface_of(ports: Ports, sample_time: float) -> Interface:
    """Return the variables of a controller with these ports and this sample time (s)."""
    signals, demands = [(name,) for name in ports.signals], [(name,) for name in ports.demands]
    faulty = [f"{name}.{fault}" for name in ports.signals for fault in FAULT_INPUTS]
    measured = (*ports.signals, *faulty)
    switches = ("Omega", "enable", "reset")
    reached = (*switches, *measured, *(f"{name}.setpoint" for name in ports.signals))
    forward = tuple(f"{name}.feedforward" for name in ports.demands)
    return interface(
        _common_parameters(sample_time),
        CHAIN,
        repeated("scales", [(name, f"of {name}") for name in ports.signals], sensor_scale),
        repeated("demands", demands, _demand_parameters),
        input_(
            "Omega",
            "rad/s",
            "Rotor speed, which selects the matrices if they depend on it",
            minimum=-LARGEST_SPEED,
            maximum=LARGEST_SPEED,
        ),
        input_(
            "enable",
            "1",
            "Whether the law acts on the demands, which are otherwise their offset plus feedforward",
            type="Boolean",
            start=1.0,
        ),
        input_("reset", "1", "Whether the integrators and other slow states are held at zero", type="Boolean"),
        repeated("signals", signals, _signal),
        repeated("faults", [(name, f"of {name}") for name in ports.signals], sensor_faults),
        repeated("feedforward", demands, _feedforward),
        output(
            "demand_limited",
            "1",
            "Whether a demand is at its limit",
            type="Boolean",
            depends_on=(*reached, *forward),
            initially_depends_on=None,
            warning="a demand is at its lower or upper limit, or at the end of the range of the DAC",
        ),
        output(
            "adc_limited",
            "1",
            "Whether a measured signal is beyond the range of the ADC",
            type="Boolean",
            depends_on=measured,
            initially_depends_on=None,
            warning="a measured signal is beyond the range of the ADC, {chain.adc_range} V at {chain.sensitivity} V/m",
        ),
        output(
            "speed_extrapolated",
            "1",
            "Whether the speed is outside the table, so that the matrices of the nearest speed are used",
            type="Boolean",
            depends_on=("Omega",),
            initially_depends_on=("Omega",),
            warning="Omega = {Omega} rad/s is outside the table, so that the matrices of the nearest speed are used",
        ),
        repeated("demand_values", [(name, reached) for name in ports.demands], _demand_output),
        repeated(
            "states",
            [(k + 1, reached) for k in range(ports.n_states)],
            _state,
            array=Array("states", "States in the coordinates of the original matrices"),
        ),
        FAULT,
    )


# A single element of each, for the record types of the parts.
SMALLEST = interface_of(Ports(("y",), ("u",), 1), 1e-4).with_all_parts()
