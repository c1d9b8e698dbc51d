"""The sampled linear loop of the levitated rotor, and the signals that measure it."""

import math
import tracemalloc
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from amb_analysis.linear.components import LinearComponent, loop_of
from amb_analysis.linear.control import pid_component
from amb_analysis.linear.loop import check_stable
from amb_analysis.linear.model import LinearModel, linear_model
from amb_analysis.linear.responses import Modes, diagonal_response
from amb_analysis.linear.rotor_and_magnets import actuator_component, bearing_slopes, rotor_component
from amb_analysis.studies.sensitivity_curves import curve_frequencies
from amb_analysis.studies.stability_margin import AxisSensitivity, peak_between_lines
from amb_cosim.model_constants.plant_data import plant
from amb_cosim.model_constants.rotor_models import actuator, control_loop, controller
from rotor_analysis.assembly import assemble
from rotor_analysis.parts import Bearing, Disc, Sensor
from rotor_analysis.reduction import msdc
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import raises_naming

FREQUENCIES = np.array([0.5, 3.0, 11.9, 20.0, 47.0, 150.0, 348.0, 700.0])


def models(rotor: Rotor) -> dict[str, Any]:
    return {"rotor": plant(rotor), "actuator": actuator(rotor), "controller": controller(rotor)}


@cache
def of_packs() -> dict[str, Any]:
    return models(load_rotor())


@dataclass
class Loop:
    """Parts of a loop, the output that feeds each input, and parameters by component."""

    parts: dict[str, LinearComponent]
    feeds: dict[str, str]
    parameters: dict[str, dict[str, float]]
    axes: list[tuple[str, str]]

    def slopes(self, axis: int) -> tuple[float, float]:
        return bearing_slopes(*self.axes[axis], self.parameters["actuator"])

    def of_axis(self, component: str, axis: int, name: str) -> float:
        bearing, direction = self.axes[axis]
        return self.parameters[component][f"{bearing}.{name}_{direction}"]

    def model(self, names: tuple[str, ...], inputs: list[str], outputs: list[str]) -> LinearModel:
        parts = [self.parts[name] for name in names]
        feeds = {t: s for t, s in self.feeds.items() if {t.split(".")[0], s.split(".")[0]} <= {*names}}
        return linear_model(loop_of(parts, feeds).selected(inputs, outputs), {}, {})


def loop(
    Omega: float = 90.0, sample_time: float = 250e-6, delay: int = 0, rotor: Rotor | None = None, **changes: float
) -> Loop:
    """The loop with the FMUs' start values; `c_b=3e3` changes it in every axis of whichever FMU has it."""
    made = of_packs() if rotor is None else models(rotor)
    if delay:
        changes = {"preset": 2.0, "delay": float(delay)} | changes
    changes["sample_time"] = sample_time
    parameters = {
        name: {
            p.name: changes.get(p.name.split(".")[-1].removesuffix("_x").removesuffix("_y"), p.start)
            for p in model.interface.of("parameter")
        }
        for name, (model, _) in made.items()
    }
    (r, constants), (a, _), (c, _) = (made[name] for name in ("rotor", "actuator", "controller"))
    bearings = a.layout["bearings"]
    parameters["rotor"] |= {f"{bearing}.{name}": 0.0 for bearing in bearings for name in ("k_b", "c_b")}
    parts = {
        "rotor": rotor_component("rotor", r.layout, constants, parameters["rotor"], Omega),
        "actuator": actuator_component("actuator", a.layout, parameters["actuator"]),
        "controller": pid_component("controller", c.layout, parameters["controller"]),
    }
    axes = [(b, d) for b in bearings for d in "xy"]
    feeds = {f"rotor.{b}.f_{d}": f"actuator.{b}.f_{d}" for b, d in axes}
    feeds |= {f"actuator.{b}.{d}": f"rotor.{b}.{d}" for b, d in axes}
    feeds |= {f"actuator.{b}.i_{d}": f"controller.{b}.i_{d}" for b, d in axes}
    sensors = [plane[d] for plane in c.layout["planes"] for d in "xy"]
    feeds |= {f"controller.{sensor}": f"rotor.{sensor}" for sensor in sensors}
    return Loop(parts, feeds, parameters, axes)


def sensitivity_system(case: Loop) -> LinearModel:
    demands = [f"actuator.{b}.i_{d}" for b, d in case.axes]
    model = case.model(("rotor", "actuator", "controller"), demands, demands)
    check_stable(model)
    return model


def plant_system(case: Loop) -> LinearModel:
    demands = [f"actuator.{b}.i_{d}" for b, d in case.axes]
    return case.model(("rotor", "actuator"), demands, [f"rotor.{b}.{d}" for b, d in case.axes])


def controller_system(case: Loop) -> LinearModel:
    signals, demands = [f"controller.{axis.sensor}" for axis in control_loop().axes], case.parts["controller"].outputs
    return -case.model(("controller",), signals, list(demands))


def continuous(Omega: float, frequencies: np.ndarray, lag: float, bandwidth: float = math.inf) -> np.ndarray:
    """1/(1 + L) of each axis with the other loops closed, L with a continuous PD controller and a dead time (s)."""
    result = load_rotor()
    model = msdc(assemble(result), result.masters).model
    B = np.eye(model.size)[:, model.rows(result.bearing_nodes)]
    k_s, _ = loop().slopes(0)
    rows = []
    for omega in 2.0 * np.pi * frequencies:
        s = 1j * omega
        dynamic = s * s * model.M + s * Omega * model.G + model.K - k_s * B @ B.T
        plant = B.T @ np.linalg.solve(dynamic, B)
        law = (1e6 + k_s + 5e3 * s) * np.exp(-s * lag) / (1.0 + omega * 1j / (2.0 * np.pi * bandwidth))
        rows.append(np.diag(np.linalg.inv(np.eye(4) + law * plant)))
    return np.array(rows).T


@pytest.mark.parametrize("Omega", [0.0, 300.0])
def test_short_sampling_tends_to_the_continuous_loop(Omega: float) -> None:
    errors = []
    for sample_time in (20e-6, 10e-6):
        S = diagonal_response(sensitivity_system(loop(Omega, sample_time)), FREQUENCIES)
        errors.append(np.abs(S / continuous(Omega, FREQUENCIES, 0.0) - 1.0).max())
    assert errors[1] < 0.02
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)


def test_delay_and_amplifier_are_dead_time_and_lag() -> None:
    """Hold and backward difference lag by half a sample each, the second only in the derivative."""

    def found(time: float, **change: float) -> np.ndarray:
        both = ({}, change)
        plain, other = (diagonal_response(sensitivity_system(loop(90.0, time, **c)), FREQUENCIES) for c in both)
        return other / plain

    time = 10e-6
    late = found(time, delay=1)
    np.testing.assert_allclose(late, continuous(90.0, FREQUENCIES, time) / undelayed(), rtol=1e-3)
    assert np.abs(late - 1.0).max() > 1e-2
    slow = found(5e-6, amplifier=1.0)
    np.testing.assert_allclose(slow, continuous(90.0, FREQUENCIES, 0.0, 1400.0) / undelayed(), rtol=2e-3)


def undelayed() -> np.ndarray:
    return continuous(90.0, FREQUENCIES, 0.0)


def test_both_directions_of_a_bearing_are_alike() -> None:
    S = diagonal_response(sensitivity_system(loop(300.0)), FREQUENCIES)
    np.testing.assert_allclose(S[[0, 2]], S[[1, 3]], rtol=1e-9)


def test_a_peak_between_lines_of_a_measurement_is_measured() -> None:
    """S = 1 + r/(1 - (f/f_0)^2 + 2 i zeta f/f_0) has its peak between lines 1.5 Hz apart, which miss a fifth of it."""
    f_0, zeta, factor = 150.7, 0.005, 1.02 * np.exp(0.02j)

    def S(f: np.ndarray) -> np.ndarray:
        return 1.0 + 0.04 / (1.0 - (f / f_0) ** 2 + 2j * zeta * f / f_0)

    closely, lines = np.linspace(140.0, 160.0, 200001), np.arange(1.0, 300.0, 1.5)
    peak, at = np.abs(S(closely)).max(), closely[np.abs(S(closely)).argmax()]
    measured = factor * S(lines)
    assert np.abs(measured).max() < 0.9 * peak
    found = peak_between_lines(peak, at, lines, measured, measured / S(lines))
    assert found == pytest.approx(1.02 * peak, rel=1e-9)


def test_a_larger_measured_value_than_at_the_computed_peak_counts() -> None:
    """The co-simulation may have a peak that the linear model lacks."""
    lines = np.array([10.0, 20.0, 30.0])
    measured = np.array([1.0, 1.5, 3.0], dtype=complex)
    assert peak_between_lines(2.0, 15.0, lines, measured, measured / np.array([1.0, 1.5, 1.2])) == 3.0


def with_response(S: np.ndarray) -> AxisSensitivity:
    return AxisSensitivity(1.0, 1.0, "A", S, np.empty(0), np.empty(0), 1.0, 0.0, 0.0)


def test_nyquist_curve_of_an_unstable_plant_encircles_minus_one() -> None:
    """A rotor in its magnets alone has one unstable pole in each axis: L turns once about -1, counterclockwise.

    Half of the turn is that from 0 to half the sample rate, where L is real at both ends.
    """
    system = sensitivity_system(loop())
    frequencies = np.geomspace(1e-3, 0.5 / system.dt, 20000)
    for S in diagonal_response(system, frequencies):
        L = with_response(S).L
        np.testing.assert_allclose(np.abs(L + 1.0), 1.0 / np.abs(S))
        angle = np.unwrap(np.angle(L + 1.0))
        assert (angle[-1] - angle[0]) / np.pi == pytest.approx(1.0, abs=0.02)


def test_computed_curve_is_smooth_about_sharp_resonances() -> None:
    """Between neighbouring frequencies S changes by a small share of its range, where all points are 1 % apart."""
    system = sensitivity_system(loop())
    S = diagonal_response(system, curve_frequencies(system.poles(), system.dt))
    assert np.abs(np.diff(S)).max() < 0.1 * np.ptp(np.abs(S))


# A shaft that does not bend, held in planes that its sensors are not in.
HELD, SEEN = (0.3, 0.9), (0.1, 1.1)  # m


def stiff_machine() -> Rotor:
    shaft = Shaft(nodes=(0.0, *HELD, 1.2), diameter=(0.05,), youngs_modulus=1e15, density=7800.0, poissons_ratio=0.3)
    return Rotor(
        "stiff",
        shaft,
        bodies=(Disc(name="drum", mass=40.0, radius=0.1, width=0.3, z=0.55),),
        bearings=tuple(Bearing(name=name, z=z) for name, z in zip(("drive", "free"), HELD, strict=True)),
        sensors=tuple(Sensor(name=name, z=z) for name, z in zip(("left", "right"), SEEN, strict=True)),
        reduction=ReductionOptions(masters=(2, 3)),
    )


def test_sensors_beside_the_bearings_close_the_loop() -> None:
    """A stiff shaft on two negative springs tilts as its bearings do: x_s = T x_b, x_b = -F/K_s, F = -(K_b + K_s) x_s.

    Near standstill S = [1 - (1 + K_b/K_s) T]^-1, and T is not 1 where sensors are not in the planes of the bearings.
    """
    k_b = 3e6
    case = loop(0.0, rotor=stiff_machine(), k_b=k_b)
    k_s, _ = case.slopes(0)
    (a, b), seen = HELD, np.array(SEEN)
    T = np.array([(b - seen) / (b - a), (seen - a) / (b - a)]).T
    expected = np.diag(np.linalg.inv(np.eye(2) - (1.0 + k_b / case.of_axis("controller", 0, "k_s")) * T))
    assert np.abs(T - np.eye(2)).max() > 0.3
    result = diagonal_response(sensitivity_system(case), np.array([1e-2]))[::2, 0]
    np.testing.assert_allclose(result, expected, rtol=2e-3)
    assert k_s == pytest.approx(case.of_axis("controller", 0, "k_s"), rel=1e-4)


def test_passive_bearing_has_no_magnet_in_the_loop() -> None:
    """Where no force of the actuator is connected, neither K_s nor K_i acts: a free rotor drifts in that plane."""
    case = loop(0.0, rotor=stiff_machine(), k_b=3e6)
    unstable = [pole for pole in plant_system(case).poles() if pole.real > 1.0]
    case.feeds = {target: source for target, source in case.feeds.items() if not source.startswith("actuator.free.")}
    plant = plant_system(case)
    assert len(unstable) == 4
    assert len([pole for pole in plant.poles() if pole.real > 1.0]) == 2
    response = plant(100j)
    assert np.abs(response[:, 2:]).max() == 0.0
    assert np.abs(response[:, :2]).max() > 0.0


def test_axis_without_static_current_has_the_stiffness_of_its_bias_alone() -> None:
    """K_s of (2.8) with I_s = 0 is less than that of an axis that carries weight; each axis has its own."""
    carrying, bare = loop().slopes(0), loop(static_current=0.0).slopes(0)
    bias, static = 4.43, 1.14
    assert bare[0] / carrying[0] == pytest.approx(2.0 * bias**2 / ((bias + static) ** 2 + bias**2), rel=1e-4)
    assert bare[1] / carrying[1] == pytest.approx(2.0 * bias / (2.0 * bias + static), rel=1e-4)


def test_direct_gains_close_the_loop_where_they_are_chosen() -> None:
    """With `pid.direct` the law has k_p and k_d in place of K_b + K_s and C_b."""
    k_s = loop().of_axis("controller", 0, "k_s")
    assumed, direct = (
        diagonal_response(controller_system(loop(**change)), FREQUENCIES)
        for change in ({"k_b": 0.5e6, "c_b": 3e3}, {"direct": 1.0, "k_p": 0.5e6 + k_s, "k_d": 3e3})
    )
    np.testing.assert_allclose(direct, assumed, rtol=1e-12)


def test_integral_action_takes_static_loads_over() -> None:
    S = diagonal_response(sensitivity_system(loop(k_integral=1e6)), np.array([1e-4, 1e-3]))
    np.testing.assert_allclose(np.abs(S[:, 1] / S[:, 0]), 10.0, rtol=0.01)
    assert np.abs(S).max() < 0.02


@pytest.mark.parametrize(
    ("switch", "off", "on", "tau", "options"),
    [
        ("derivative_time", 0.0, 1e-4, 1e-4, {"k_b": 0.0, "k_s": 0.0}),
        ("filter", 0, 1, 1.0 / (2.0 * np.pi * 2000.0), {"preset": 2, "cutoff": 2000.0}),
    ],
)
def test_filters_of_derivative_and_signal_are_lags(
    switch: str, off: float, on: float, tau: float, options: dict[str, float]
) -> None:
    sharp, filtered = (
        diagonal_response(controller_system(loop(sample_time=1e-6, **options, **{switch: value})), FREQUENCIES)
        for value in (off, on)
    )
    lag = np.broadcast_to(1.0 / (1.0 + 2j * np.pi * FREQUENCIES * tau), sharp.shape)
    np.testing.assert_allclose(filtered / sharp, lag, rtol=5e-3 if switch == "derivative_time" else 1e-4)


def test_unstable_loop_is_refused_with_its_growing_vibration() -> None:
    with pytest.raises(ValueError, match=r"35\d\.\d+ Hz .* 0\.01"):
        sensitivity_system(loop(sample_time=1e-3))
    with raises_naming(ValueError, "drift"):
        sensitivity_system(loop(k_b=-1e5))


def test_measured_law_takes_the_measured_constants() -> None:
    assert loop(force_law=1.0).slopes(2) == (2.156e6, 539.0)
    k_s, k_i = loop(force_law=2.0).slopes(0)
    assert (k_s / 1e3, k_i) == pytest.approx((2376.96, 563.15), rel=1e-5)


def test_a_response_from_modes_holds_no_array_over_modes_and_outputs():
    """Each frequency divides once by each mode, not once for each output, which took three times as long."""
    random, n = np.random.default_rng(0), 2000
    outputs, poles = 6, 0.9 * np.exp(2j * math.pi * random.random(80))
    modes = Modes(poles, random.normal(size=(outputs, 80)) + 0j, random.normal(size=(80, 2)) + 0j)
    z = np.exp(1j * np.linspace(0.1, 3.0, n))
    tracemalloc.start()
    H = modes.response(z)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.8 * 16 * n * outputs * 80
    expected = modes.of_outputs @ np.diag(1.0 / (z[7] - poles)) @ modes.of_inputs
    np.testing.assert_allclose(H[7], expected, rtol=1e-12)
