"""An upright rotor loses its magnets at full speed and falls onto its lower face, against independent computations."""

import numpy as np
import pytest
from upright_pump import REFERENCE, START, P, landing, set_lateral

H, MS = 50e-6, 20  # step (s), steps in a millisecond
COUNTERS = {"face_impulse": "seat.f_n_mean", "face_torque_impulse": "seat.torque"}


def journals(x):
    return np.array([x["mb1.x"], x["mb1.y"], x["mb2.x"], x["mb2.y"]])


# Worst deviation of the journals over 50 ms in a share of the clearance: the closed form is that of the plant, the ring
# of points lets its points lift one by one.
@pytest.mark.parametrize(
    ("name", "allowed"), [("closed_form_on_mounts", 1e-3), ("ring_fixed", 4e-3), ("ring_on_mounts", 0.02)]
)
def test_a_landing_matches_an_independent_computation(name, allowed):
    case = REFERENCE["cases"][name]
    x, peak, totals = landing(case), 0.0, dict.fromkeys(COUNTERS, 0.0)
    for row in (dict(zip(REFERENCE["columns"], row, strict=True)) for row in case["rows"][1:]):
        for n in range(MS):
            x.step(row["t"] - 1e-3 + n * H, H)
            peak = max(peak, x["seat.f_n_peak"])
            totals = {name: total + H * x[COUNTERS[name]] for name, total in totals.items()}
        expected = [row[f"{journal}_{axis}"] for journal in ("lower", "upper") for axis in "xy"]
        assert np.max(np.abs(journals(x) - expected)) <= allowed * P["c0"]
    assert peak == pytest.approx(case["peak_force"], rel=2e-4)
    assert x["thrust.z"] + START["gap"] == pytest.approx(row["z"], abs=allowed * START["gap"])
    assert P["Jp"] * (START["Omega"] - x["speed"]) == pytest.approx(P["Jp"] * (START["Omega"] - row["Omega"]), rel=2e-3)
    for name, total in totals.items():
        assert total == pytest.approx(row[name], rel=1e-3), name
    assert x["seat.heat"] == pytest.approx(row["face_heat"], rel=2e-3)  # that of the reference is of friction alone
    assert x["seat.heat"] > row["face_heat"]


@pytest.mark.parametrize("name", REFERENCE["cases"])
@pytest.mark.parametrize("free", [0.0, 1.0], ids=["given speed", "free spin"])
def test_the_heat_of_a_landing_is_its_work(name, free):
    case = REFERENCE["cases"][name]
    x, largest = landing(case, **{"spin.free": free}), 0.0
    for n in range(30 * MS):
        x.step(n * H, H)
        largest = max(largest, abs(x["energy.balance"]))
    assert x["seat.heat"] > 5.0
    assert largest < 1e-6 * x["energy.dissipated"]


def test_steps_of_any_length_land_alike():
    """The parts in which z and lean know each other follow from the face, not from the step."""
    case = REFERENCE["cases"]["closed_form_on_mounts"]
    ends = []
    for h in (10e-6, 50e-6, 250e-6):
        x = landing(case)
        for n in range(round(20e-3 / h)):
            x.step(n * h, h)
        ends.append(journals(x))
    assert np.max(np.abs(np.diff(ends, axis=0))) < 1e-3 * P["c0"]


@pytest.mark.parametrize("turn", [1j, np.exp(0.7j)])
def test_a_turned_landing_is_the_same_landing_turned(turn):
    case = REFERENCE["cases"]["closed_form_on_mounts"] | {"seat_tilt_x": 0.0}
    x, y = landing(case), landing(case)
    seat = 2e-4 * turn
    y["seat.seat_tilt_x"], y["seat.seat_tilt_y"], x["seat.seat_tilt_x"] = seat.real, seat.imag, 2e-4
    lean, rate = START["lean_x"] + 1j * START["lean_y"], START["lean_rate_x"] + 1j * START["lean_rate_y"]
    set_lateral(y, 0.0, turn * (START["vx"] + 1j * START["vy"]), turn * lean, turn * rate)
    set_lateral(x, 0.0, START["vx"] + 1j * START["vy"], lean, rate)
    for n in range(15 * MS):
        x.step(n * H, H)
        y.step(n * H, H)
    there, turned = journals(x), journals(y)
    np.testing.assert_allclose(turned[::2] + 1j * turned[1::2], turn * (there[::2] + 1j * there[1::2]), atol=1e-9)
    assert y["seat.heat"] == pytest.approx(x["seat.heat"], rel=1e-9)


def test_a_restored_state_goes_on_with_the_landing():
    x = landing(REFERENCE["cases"]["closed_form_on_mounts"])
    for n in range(8 * MS):
        x.step(n * H, H)
    assert x["seat.mode"] == 1.0
    y = type(x)(x.model, x.constants)
    y.parameters[:], y.inputs[:], y.state[:] = x.parameters, x.inputs, x.state
    for n in range(8 * MS, 12 * MS):
        x.step(n * H, H)
        y.step(n * H, H)
    np.testing.assert_array_equal(y.state, x.state)
    np.testing.assert_array_equal(y.outputs, x.outputs)
