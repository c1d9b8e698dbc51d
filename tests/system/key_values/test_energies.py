"""Each energy of the plant alone: from waveforms of runs, and from the motion on a grid of 5 us with own matrices.

The matrices are those of `rotor_cases.OnePlane`, which shares no code with the package. What the books of whole steps
and pieces call heat or work is here a power, integrated by the trapezoidal rule.
"""

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, H, OnePlane, both, masters, place, plant, run
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.rotor_file import load_rotor

G = 9.81
FINE, STEPS = 50, 20  # parts of a step, steps
TERMS = ("kinetic", "strain", "damping", "friction", "impact", "work")
SOMEWHERE = CLEARANCE * np.array([1, 1j, -1, 0.5, -1j, 1])
PUSHED = {"mb1.f_x": 300.0, "mb1.k_xx": 4e5, "mb1.x_ref": 1e-4, "mb2.f_y": -200.0, "mb2.k_yy": 3e5, "d2.f_x": 150.0}
ROLLS = {"initial.orbit": 1.0, "Omega": 90.0, "d1.u": 0.094, "rb2.enabled": 0.0}
SITUATIONS = {  # values, initial motion, steps before
    "free whirl": (BEARINGS | {"Omega": 260.0, "d1.u": 0.5e-3}, SOMEWHERE * 0.3, 0),
    "pushed, with weight": (BEARINGS | PUSHED | {"Omega": 150.0, "gravity": G}, SOMEWHERE * 0.1, 0),
    "on a moving base": (BEARINGS | {"Omega": 150.0, "base.a_x": 8.0, "base.a_y": -5.0}, SOMEWHERE * 0.1, 0),
    "sliding": (both("rb.mu", 0.1) | {"Omega": 100.0, "gravity": G}, None, 3000),
    "rolling": (BEARINGS | both("rb.mu", 2.0) | ROLLS, None, 400),
}


def continued(x):
    """Another instance in the same state."""
    y = type(x)(x.model, x.constants)
    y.parameters[:], y.inputs[:], y.state[:] = x.parameters, x.inputs, x.state
    return y


def powers(x, model):
    """Kinetic and strain energy, and the powers of damping, friction and all inputs, of the present state."""
    r, v = masters(x)
    at, Omega = model.bearings, x["Omega"]
    direction = np.exp(1j * x["gravity_angle"]) * x["gravity"] - (x["base.a_x"] + 1j * x["base.a_y"])
    force = model.M @ np.full(len(r), direction)
    u = [x[f"d{k}.u"] * np.exp(1j * x[f"d{k}.phi"]) for k in range(1, 5)]
    force = force + Omega**2 * model.unbalance(u) * np.exp(1j * x["theta"])
    force = force + model.T.T @ sum(
        (x[f"d{k}.f_x"] + 1j * x[f"d{k}.f_y"]) * np.eye(len(model.T))[model.discs[k - 1]] for k in range(1, 5)
    )
    for k, node in enumerate(at, 1):
        z = r[node]
        force[node] += x[f"mb{k}.f_x"] + x[f"mb{k}.k_xx"] * (z.real - x[f"mb{k}.x_ref"])
        force[node] += 1j * (x[f"mb{k}.f_y"] + x[f"mb{k}.k_yy"] * (z.imag - x[f"mb{k}.y_ref"]))
    sliding = driving = 0.0
    for site in ("rb1", "rb2"):
        if x[f"{site}.mode"] > 0:
            driving -= x[f"{site}.f_t"] * x[f"{site}.journal_radius"] * Omega
            sliding -= x[f"{site}.f_t"] * x[f"{site}.slip_velocity"]
    return (
        0.5 * np.vdot(v, model.M @ v).real,
        0.5 * np.vdot(r, model.K @ r).real,
        np.vdot(v, model.C @ v).real,
        sliding,
        0.0,
        np.vdot(v, force).real + driving,
    )


@pytest.mark.parametrize("name", SITUATIONS)
def test_each_energy_is_the_integral_of_its_power(name):
    values, motion, before = SITUATIONS[name]
    x = plant(values)
    if motion is not None:
        place(x, motion, 80.0 * motion)
    run(x, before)
    model = OnePlane.of(load_rotor(), x["mb1.k_b"], x["mb1.c_b"])
    fine, h = continued(x), H / FINE
    begin = before * H
    first = run(continued(x), 1, [f"energy.{term}" for term in TERMS], start=begin)[0]
    given = run(x, STEPS, [f"energy.{term}" for term in TERMS], start=begin)[-1] - first
    run(fine, FINE, h=h, start=begin)
    series = [powers(fine, model)]
    for n in range(FINE, FINE * STEPS):
        fine.step(begin + n * h, h)
        series.append(powers(fine, model))
    series = np.array(series)
    expected = [*(series[-1, :2] - series[0, :2]), *np.trapezoid(series[:, 2:], dx=h, axis=0)]
    largest = np.abs(expected).max()
    for term, found, own in zip(TERMS, given, expected, strict=True):
        assert found == pytest.approx(own, rel=1e-3, abs=1e-5 * largest), term
    assert (expected[3] > 0.01 * largest) == (name == "sliding")


def rotor_mass(name):
    return load_rotor(rotor_path(name)).mass


def test_an_upright_landing_divides_its_energy_by_torques(record_of):
    """Friction is that of the face and the race's drag, damping that of the spin; each slows the rotor or the race."""
    r = record_of("upright landing")
    h, speed, race = r.h, r["speed"], r["catch_lower.race_speed"]
    torque, drag = r["seat.torque"][1:], r.of_plant["catch_lower.race_drag"]
    slip = 0.5 * np.add(*(values[k:][: len(torque)] for k, values in ((0, speed - race), (1, speed - race))))
    of_race = drag * np.trapezoid(race, dx=h)
    damping = np.trapezoid(r.of_plant["spin.drag"] * speed**2, dx=h)
    gained = {
        name: r[f"energy.{name}"][-1] - r[f"energy.{name}"][0] for name in ("damping", "friction", "impact", "work")
    }
    assert gained["damping"] == pytest.approx(damping, rel=1e-6)
    assert gained["friction"] == pytest.approx(-h * np.sum(torque * slip) + of_race, rel=1e-6)
    slowed = np.trapezoid(r.of_plant["spin.drag"] * speed, dx=h) - h * np.sum(torque)
    assert r.of_plant["spin.inertia"] * (speed[0] - speed[-1]) == pytest.approx(slowed, rel=1e-6)
    assert r["catch_lower.heat"][-1] == pytest.approx(gained["friction"] + gained["impact"], rel=1e-6)


def test_an_upright_landing_has_the_impulse_of_its_weight(record_of):
    """m v' = N + F - m g, over the run, with the force of the magnet held in each step."""
    r = record_of("upright landing")
    mass, h = rotor_mass("turbo_pump"), r.h
    magnet = h * np.sum(r.signals["amb_actuator.thrust.f_z"][1:])
    weight = mass * r.of_plant["gravity"] * r.t[-1]
    expected = mass * (r["thrust.speed"][-1] - r["thrust.speed"][0]) + weight - magnet
    assert r.given["touchdown"]["retainers"]["seat"]["impulse_Ns"] == pytest.approx(expected, rel=1e-4)


def test_the_heat_of_a_landing_is_what_spin_races_and_weight_lose(record_of):
    """Strain and lateral motion keep less than a thousandth of it."""
    r = record_of("landing")
    spin = 0.5 * r.of_plant["spin.inertia"] * (r["speed"][0] ** 2 - r["speed"][-1] ** 2)
    races = sum(0.5 * r.of_plant[f"{s}.race_inertia"] * r[f"{s}.race_speed"][-1] ** 2 for s in r.places["sites"])
    fallen = np.mean([r.given["touchdown"]["drop_mm"][bearing] for bearing in r.places["bearings"]])
    weight = rotor_mass("bath_rig") * r.of_plant["gravity"] * 1e-3 * fallen
    heat = sum(r.given["energy_J"][name] for name in ("damping", "friction", "impact"))
    assert heat == pytest.approx(spin - races + weight, rel=3e-3)


def test_the_peak_of_an_upright_landing_is_that_of_a_mass_on_its_ring(record_of):
    """m w'' = m g - k w - d w' from the speed at which the face meets its seat; the damper gives the restitution."""
    r = record_of("upright landing")
    mass, k, e = rotor_mass("turbo_pump"), r.of_plant["seat.stiffness"], r.of_plant["seat.restitution"]
    before = int(np.flatnonzero(r["seat.mode"])[0]) - 1
    speed = np.sqrt(r["thrust.speed"][before] ** 2 + 2.0 * G * r["seat.gap"][before])

    def after(d, weight):
        """Speed at which the mass leaves, and largest force."""

        def force(t, y):
            return k * y[0] + d * y[1] if t > 0.0 else 1.0

        force.terminal = True

        def rates(t, y):
            return [y[1], weight - (k * y[0] + d * y[1]) / mass]

        found = solve_ivp(rates, (0.0, 1.0), [0.0, speed], rtol=1e-10, atol=1e-14, max_step=1e-5, events=force)
        return -found.y[1, -1], np.max(k * found.y[0] + d * found.y[1])

    damping = brentq(lambda d: after(d, 0.0)[0] - e * speed, 1.0, 2.0 * np.sqrt(k * mass), rtol=1e-8)
    assert r.given["peak_contact_force_N"]["seat"] == pytest.approx(after(damping, G)[1], rel=1e-3)
