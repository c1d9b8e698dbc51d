"""Currents, forces and saturation of the magnets, compared with separate models of amplifier and field."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

MU_0 = 4e-7 * np.pi
SMOOTH = {"rtol": 1e-9, "atol": 1e-12, "max_step": 2e-5}


class Axis:
    """An axis of a magnet: its signals, parameters and laws."""

    def __init__(self, record, magnet, axis):
        p = record.parameters["amb_actuator"]
        self.p = {
            name.removeprefix(f"{magnet}.").removesuffix(f"_{axis}"): value
            for name, value in p.items()
            if name.startswith(f"{magnet}.") and name.endswith(f"_{axis}")
        }
        self.signals = {
            name: record.signals[f"amb_actuator.{magnet}.{name}_{axis}"]
            for name in ("f", "i_upper", "i_lower", "saturated")
        }
        self.x = record.signals[f"amb_actuator.{magnet}.{axis}_ref"]
        self.demand, self.t = record.signals[f"rolac_controller.{magnet}.i_{axis}"], record.t
        off = record.signals.get(f"amb_actuator.{magnet}.amplifier_off_{axis}")
        self.off = np.zeros(len(self.t)) if off is None else off
        self.levels = self.p["static_current"] + self.p["bias_current"], self.p["bias_current"]

    def rate(self, i, wanted, off):
        """di/dt of a coil: its regulator within +-V, or its diodes against the supply until the current is zero."""
        R, L, V = (self.p[name] for name in ("resistance", "inductance", "voltage_limit"))
        if off:
            return (-np.sign(i) * self.p["discharge_voltage"] - R * i) / L if abs(i) > 1e-9 else 0.0
        v = L * 2.0 * np.pi * self.p["bandwidth"] * (wanted - i) + R * i
        return (min(max(v, -V), V) - R * i) / L

    def course(self, k, of_upper):
        """Current at the end of step k and its mean in the step, from the current at its beginning."""
        sign, level = (1.0, self.levels[0]) if of_upper else (-1.0, self.levels[1])
        begin, h = self.signals["i_upper" if of_upper else "i_lower"][k - 1], self.t[k] - self.t[k - 1]
        low = max(-self.levels[0], self.levels[1] - self.p["current_limit"])
        high = min(self.p["current_limit"] - self.levels[0], self.levels[1])
        wanted = level + sign * min(max(self.demand[k], low), high)
        off = self.off[k] != 0.0

        def rates(t, y):
            return [self.rate(y[0], wanted, off), y[0]]

        y = solve_ivp(rates, (0.0, h), [begin, 0.0], **SMOOTH).y[:, -1]
        return max(y[0], 0.0) if off else y[0], y[1] / h

    def flux(self, current, distance):
        """Flux density (T): linear up to the knee, then a parabola up to saturation."""
        b, b_sat, width = MU_0 * self.p["turns"] * current / distance, self.p["b_sat"], self.p["knee_width"]
        knee = (1.0 - width) * b_sat
        if b <= knee:
            return b
        return b_sat if b >= (1.0 + width) * b_sat else b - (b - knee) ** 2 / (4.0 * width * b_sat)

    def pull(self, upper, lower, x):
        area = self.p["pole_area"] * np.cos(self.p["half_angle"]) / MU_0
        return area * (self.flux(upper, self.p["gap"] - x) ** 2 - self.flux(lower, self.p["gap"] + x) ** 2)


def axes(record):
    return [Axis(record, magnet, axis) for magnet in record.places["bearings"] for axis in "xy"]


@pytest.mark.parametrize("kind", ["sensor loss", "base shock"])
def test_currents_follow_the_equation_of_the_amplifier(record_of, kind):
    record = record_of(kind)
    for axis in axes(record):
        for k in range(20, 100, 7):
            for name, of_upper in (("i_upper", True), ("i_lower", False)):
                expected = axis.course(k, of_upper)[0]
                assert axis.signals[name][k] == pytest.approx(expected, rel=1e-5, abs=1e-6), (name, k)


def test_currents_decay_against_the_supply(record_of):
    """i = (i_0 + V/R) exp(-R t/L) - V/R until it is zero; with the time L/R ln(1 + R i_0/V)."""
    record = record_of("landing")
    for axis in axes(record):
        R, L, V = (axis.p[name] for name in ("resistance", "inductance", "discharge_voltage"))
        for i in (axis.signals["i_upper"], axis.signals["i_lower"]):
            expected = np.maximum((i[0] + V / R) * np.exp(-R * axis.t / L) - V / R, 0.0)
            assert i[0] > 1.0
            np.testing.assert_allclose(i, expected, atol=1e-9)
            assert axis.t[np.argmax(i == 0.0)] == pytest.approx(L / R * np.log1p(R * i[0] / V), abs=record.h)


@pytest.mark.parametrize("kind", ["landing", "sensor loss", "base shock"])
def test_forces_are_those_of_the_field_with_saturation(record_of, kind):
    """Of the mean currents of the step, at the displacement at its beginning."""
    record = record_of(kind)
    for axis in axes(record):
        for k in range(1, len(record.t), 23) if kind != "landing" else range(1, 9, 2):
            upper, lower = axis.course(k, True)[1], axis.course(k, False)[1]
            assert axis.signals["f"][k] == pytest.approx(axis.pull(upper, lower, axis.x[k]), rel=1e-4, abs=1e-3), k


@pytest.mark.parametrize("kind", ["levitation", "run-up"])
def test_forces_of_a_linear_law_have_the_slopes_of_the_field(record_of, kind):
    """K_i i + K_s x of the operating point, by differences of the field without saturation, or as measured."""
    record = record_of(kind)
    for axis in axes(record):
        above, below = axis.levels
        axis.p["b_sat"] = 1e9
        k_i = (axis.pull(above + 1e-4, below - 1e-4, 0.0) - axis.pull(above - 1e-4, below + 1e-4, 0.0)) / 2e-4
        k_s = (axis.pull(above, below, 1e-8) - axis.pull(above, below, -1e-8)) / 2e-8
        if record.parameters["amb_actuator"]["force_law"] == 1:
            k_i, k_s = axis.p["k_i_measured"], axis.p["k_s_measured"]
        i = axis.signals["i_upper"] - above
        np.testing.assert_allclose(axis.signals["f"], k_s * axis.x + k_i * i, rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("kind", ["sensor loss", "base shock", "rub"])
def test_saturation_is_flagged_beyond_the_knee(record_of, kind):
    record, seen = record_of(kind), 0
    for axis in axes(record):
        for k in range(1, len(record.t)):
            upper, lower = axis.signals["i_upper"][k], axis.signals["i_lower"][k]
            b = [
                MU_0 * axis.p["turns"] * i / d
                for i, d in ((upper, axis.p["gap"] - axis.x[k]), (lower, axis.p["gap"] + axis.x[k]))
            ]
            share = max(b) / ((1.0 - axis.p["knee_width"]) * axis.p["b_sat"])
            if abs(share - 1.0) > 0.03:  # the flag is that of the mean current of the step
                assert axis.signals["saturated"][k] == (share > 1.0), k
                seen += share > 1.0
    assert seen > 5
