"""Faces along the shaft: bounces, friction of a ring, whirl, spin-down, lateral decay, and what they leave alone."""

from dataclasses import replace

import numpy as np
import pytest
from rotor_cases import BEARINGS, H, check_collected, memory, plant, run
from scipy.integrate import solve_ivp
from upright_pump import START, P, landing, pump, set_lateral, upright

from rotor_analysis.parts import Face, ThrustDisc
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.contact.axial_contact import move_onto_faces
from rotor_contact.contact.faces import FACE, damping_of, friction, friction_of_ring
from rotor_contact.forces.axial_motion import AXIAL
from rotor_contact.variables.enumerations import PIECES
from rotor_contact.variables.signals import AXIAL_INPUTS, AXIAL_PARAMETERS

G, GAP, MASS, R, HEIGHT = P["g"], START["gap"], P["m"], P["R"], P["h"]
WEIGHT = MASS * G
OMEGA = START["Omega"]


def one(dtype, **values):
    """An array of one record."""
    result = np.zeros(1, dtype=dtype).view(np.recarray)
    for name, value in values.items():
        result[name] = value
    return result


class Fall:
    """A mass falls onto a face below it, without lean."""

    def __init__(self, stiffness, restitution, side=1.0):
        damping = damping_of(restitution, stiffness, MASS)
        of_face = {
            "enabled": 1.0,
            "clearance": GAP,
            "stiffness": stiffness,
            "damping": damping,
            "side": side,
            "radius": R,
        }
        self.face, self.motion = one(FACE, **of_face), one(AXIAL)
        self.tilt = one(AXIAL_PARAMETERS, tilt=side * np.pi / 2)
        self.inputs = one(AXIAL_INPUTS)
        self.work = 0.0

    def move(self, t):
        args = self.tilt[0], self.inputs[0], self.motion[0], self.face, t
        self.work += move_onto_faces(MASS, G, *args)
        return self

    @property
    def height(self):
        return GAP + self.face["side"][0] * self.motion["z"][0]

    @property
    def speed(self):
        return self.face["side"][0] * self.motion["speed"][0]


@pytest.mark.parametrize("side", [1.0, -1.0], ids=["below", "above"])
def test_bounces_on_a_rigid_face_have_the_times_of_a_ball(side):
    """Each flight is e times as long as the one before, the first fall half a flight."""
    fall, e, first = Fall(1e20, 0.3, side), 0.3, np.sqrt(2.0 * GAP / G)
    touches = first + 2.0 * first * np.cumsum([0.0, *(e**k for k in range(1, 5))])
    np.testing.assert_allclose(touches[:5], [7.13922e-3, 11.42274e-3, 12.70780e-3, 13.09332e-3, 13.20898e-3], rtol=1e-6)
    now = 0.0
    for number, touch in enumerate(touches[:5]):
        fall.move(touch - 1e-9 - now)
        assert fall.face["impulse"][0] == pytest.approx((1.0 + e) * MASS * G * first * sum(e**k for k in range(number)))
        fall.move(2e-9)
        now = touch + 1e-9
        assert fall.speed == pytest.approx(e ** (number + 1) * G * first, abs=2e-9 * G)
    fall.move(5.0 * first)
    assert abs(fall.speed) < 1e-9
    assert fall.face["is_pressed"][0] == 1.0


@pytest.mark.parametrize("e", [0.06, 0.13, np.exp(-2.0), 0.3, 0.7, 1.0])
def test_a_face_returns_the_wanted_share_of_the_speed(e):
    fall = Fall(3e7, e)
    fall.motion["z"], fall.motion["speed"] = -GAP, -0.2
    fall.tilt["tilt"] = 0.0  # without weight
    heat = 0.0
    for _ in range(100):
        fall.move(1e-4)
        heat += fall.face["loss"][0]
    assert fall.speed == pytest.approx(0.2 * e, rel=1e-8)
    assert heat == pytest.approx(0.5 * MASS * 0.04 * (1.0 - e * e), rel=1e-8, abs=1e-15)


@pytest.mark.parametrize("parts", [1, 7])
def test_a_contact_is_half_a_vibration_in_any_parts(parts):
    fall, rate = Fall(3e7, 1.0), np.sqrt(3e7 / MASS)
    fall.motion["z"], fall.motion["speed"], fall.tilt["tilt"] = -GAP, -0.05, 0.0
    for _ in range(parts):
        fall.move(0.7 * np.pi / rate / parts)
    assert fall.height == pytest.approx(-0.05 / rate * np.sin(0.7 * np.pi), rel=1e-12)
    assert fall.face["f_n_peak"][0] == pytest.approx(0.05 / rate * 3e7, rel=2e-4)
    assert fall.face["impulse"][0] == pytest.approx(MASS * 0.05 * (1.0 - np.cos(0.7 * np.pi)), rel=1e-12)


def test_a_leaning_ring_meets_its_seat_with_one_side_first():
    """N is the integral over the ring; at rest the weight is on the part that touches."""
    fall = Fall(3e7, 0.3)
    fall.face["lean"] = 10e-6
    for _ in range(4000):
        fall.move(50e-6)
    angles = 2.0 * np.pi * (np.arange(100000) + 0.5) / 100000
    depth = np.maximum(-fall.height + 10e-6 * np.cos(angles), 0.0)
    assert 0.2 < np.mean(depth > 0.0) < 0.8
    assert 3e7 * np.mean(depth) == pytest.approx(WEIGHT, rel=1e-6)
    assert fall.face["force"][0] == pytest.approx(WEIGHT, rel=1e-6)


@pytest.mark.parametrize("rho", [1e-3, 0.05, 0.0999, 0.1001, 0.5, 1.0 - 1e-9, 1.0, 1.3, 9.99, 10.01, 300.0])
def test_friction_of_a_ring_is_the_mean_of_coulombs_law(rho):
    angles = 2.0 * np.pi * (np.arange(200000) + 0.5) / 200000
    slip = rho + 1j * np.exp(1j * angles)  # v along x, omega R = 1
    along = slip / np.abs(slip)
    force, torque = np.mean(along.real), np.mean((np.exp(-1j * angles) * along).imag)
    near_one = 1e-5 if abs(rho - 1.0) < 1e-6 else 1e-9
    assert friction_of_ring(rho) == pytest.approx((force, torque), rel=near_one)


@pytest.mark.parametrize("omega", [900.0, -900.0])
@pytest.mark.parametrize("v", [0.0, 3.0 - 1.0j, 40.0j])
@pytest.mark.parametrize("e", [0.0, 0.4 + 0.3j])
def test_friction_of_a_face_only_takes_energy(omega, v, e):
    face = one(FACE, mu=0.2, radius=R)[0]
    f_x, f_y, torque = friction(face, 100.0, e.real, e.imag, v.real, v.imag, omega)
    assert f_x * v.real + f_y * v.imag + torque * omega < 0.0
    assert np.hypot(f_x, f_y) <= 20.0 * (1.0 + 1e-12)
    assert abs(torque) <= 20.0 * R * (1.0 + 1e-12)
    turned = friction(face, 100.0, -e.imag, e.real, -v.imag, v.real, omega)
    assert turned == pytest.approx((-f_y, f_x, torque), rel=1e-12, abs=1e-12)


def resting(values, rotor=None, side=1.0):
    """The pump on its seat, pressed by its weight."""
    away = {"lower.enabled": 0.0, "upper.enabled": 0.0}
    x = upright(away | values, rotor)
    memory(x).axial[0].z = -side * (GAP + WEIGHT / x["seat.stiffness"])
    memory(x).faces[0].is_pressed = 1.0
    return x


def whirl_roots(mu, damping, Omega, side=1.0, speed_of_seat=0.0):
    """J_t l^2 - (i J_p Omega - d_t (1 - i kappa)) l + k_t (1 - i kappa) + n N s = 0, the face at the height s."""
    k_t, d_t = 0.5 * P["k"] * R * R, 0.5 * damping * R * R
    kappa = side * mu * HEIGHT / R * np.sign(Omega - speed_of_seat)
    turned = 1.0 - 1j * kappa
    return np.roots([P["Jt"], -(1j * P["Jp"] * Omega - d_t * turned), k_t * turned - side * WEIGHT * HEIGHT])


WHIRL = {
    "forward nutation is driven": (0.12, 1.0, OMEGA, 1.0, 0.0, 30.2),
    "more by more friction": (0.2, 1.0, OMEGA, 1.0, 0.0, 50.3),
    "less with loss": (0.2, 0.8, OMEGA, 1.0, 0.0, 42.8),
    "no longer with much loss": (0.12, 0.3, OMEGA, 1.0, 0.0, -19.4),
    "the other way round": (0.12, 1.0, -OMEGA, 1.0, 0.0, 30.2),
    "damped by a race that is faster": (0.12, 1.0, OMEGA, 1.0, 1.5 * OMEGA, -30.2),
    "damped by a seat above": (0.12, 1.0, OMEGA, -1.0, 0.0, -30.2),
}


@pytest.mark.parametrize(("mu", "e", "Omega", "side", "of_seat", "known"), WHIRL.values(), ids=WHIRL)
def test_whirl_at_a_face_grows_as_its_closed_form(mu, e, Omega, side, of_seat, known):
    """Nutation, from its own shape; friction at a face far from the centre of mass drives it."""
    damping = damping_of(e, P["k"], MASS)
    roots = whirl_roots(mu, damping, Omega, side, of_seat)
    root = max(roots, key=lambda value: abs(value.imag))
    assert root.real == pytest.approx(known, abs=0.06)
    values = {"seat.mu": mu, "seat.restitution": e, "Omega": Omega, "thrust.tilt": side * np.pi / 2}
    if of_seat:
        values |= {"lower.race_inertia": 1.0}
    x = resting(values, pump("-z" if side > 0.0 else "+z"), side)
    lean = 1e-6
    k_t, d_t = 0.5 * P["k"] * R * R, 0.5 * damping * R * R
    force = -1j * mu * np.sign(Omega - of_seat) / R * side * (k_t + d_t * root) * lean
    centre = force / MASS / root**2
    set_lateral(x, centre, root * centre, lean, root * lean)
    if of_seat:
        set_race(x, of_seat)
    leans = []
    for n in range(1200):
        x.step(n * 50e-6, 50e-6)
        leans.append(np.hypot(x["mb2.x"] - x["mb1.x"], x["mb2.y"] - x["mb1.y"]))
    growth = np.polyfit(50e-6 * np.arange(1200), np.log(leans), 1)[0]
    assert growth == pytest.approx(root.real, rel=0.01)


def set_race(x, speed):
    """Set the speed of the lower race, the first degree of freedom after those of the shaft."""
    z, n = memory(x).z, 5
    z[n + 4] = speed


def test_slow_backward_precession_is_driven_by_a_seat_above():
    """With the seat above, friction pushes the other way: the other whirl grows."""
    roots = whirl_roots(0.12, 0.0, OMEGA, -1.0)
    root = min(roots, key=lambda value: abs(value.imag))
    assert root.real > 20.0
    assert root.imag < 0.0
    x = resting({"seat.mu": 0.12, "thrust.tilt": -np.pi / 2}, pump("+z"), -1.0)
    set_lateral(x, 0.0, 0.0, 1e-6, root * 1e-6)
    leans = []
    for n in range(2400):
        x.step(n * 50e-6, 50e-6)
        leans.append(np.hypot(x["mb2.x"] - x["mb1.x"], x["mb2.y"] - x["mb1.y"]))
    assert np.mean(leans[1800:]) > 3.0 * np.mean(leans[:600])


def test_a_spin_runs_down_on_its_face():
    x = resting({"seat.mu": 0.12, "spin.free": 1.0, "spin.inertia": P["Jp"]})
    for n in range(200):
        x.step(n * 1e-3, 1e-3)
    assert x["speed"] == pytest.approx(OMEGA - 0.12 * WEIGHT * R * 0.2 / P["Jp"], rel=1e-8)
    assert x["seat.torque"] == pytest.approx(-0.12 * WEIGHT * R, rel=1e-6)
    gone = 0.5 * P["Jp"] * (OMEGA**2 - x["speed"] ** 2)
    assert x["seat.heat"] == pytest.approx(gone, rel=1e-5)


def test_a_stopped_spin_stays_stopped():
    x = resting({"seat.mu": 0.12, "spin.free": 1.0, "spin.inertia": P["Jp"], "Omega": 0.5})
    for n in range(400):
        x.step(n * 1e-3, 1e-3)
    assert abs(x["speed"]) < 1e-6
    assert x["seat.heat"] == pytest.approx(0.5 * P["Jp"] * 0.25, rel=1e-3)


def test_a_face_turns_the_race_on_which_it_lands():
    inertia, drag = 6e-6, 5e-3
    values = {"seat.mu": 0.12, "lower.race_inertia": inertia, "lower.race_drag": drag}
    x = resting(values)
    for n in range(200):
        x.step(n * 1e-4, 1e-4)
    assert x["lower.race_speed"] == pytest.approx((0.12 * WEIGHT * R - drag) / inertia * 0.02, rel=1e-3)
    for n in range(200, 4000):
        x.step(n * 1e-4, 1e-4)
    assert x["lower.race_speed"] == pytest.approx(OMEGA, rel=1e-4)
    assert x["seat.torque"] == pytest.approx(-drag, rel=1e-3)


def test_lateral_motion_on_a_face_decays_with_a_power_of_the_speed():
    """Without lean, v = v_0 (Omega/Omega_0)^(J_p/(2 m R^2)): friction of a spinning ring is nearly a viscous damper."""
    rotor = pump(at=2)
    rotor = replace(rotor, faces=(replace(rotor.faces[0], retainer=None),))
    x = resting({"seat.mu": 0.5, "gravity": 10.0 * G, "spin.free": 1.0, "spin.inertia": P["Jp"]}, rotor)
    memory(x).axial[0].z = -GAP - 10.0 * WEIGHT / P["k"]
    set_lateral(x, 0.0, 1e-3, 0.0, 0.0)
    n = 0
    while x["speed"] > 0.9 * OMEGA:
        x.step(n * 2e-3, 2e-3)
        n += 1
    speed = memory(x).z[5]  # of the lower journal along x; five degrees of freedom, with the spin
    expected = 1e-3 * (x["speed"] / OMEGA) ** (P["Jp"] / (2.0 * MASS * R * R))
    assert speed == pytest.approx(expected, rel=2e-3)


def test_an_impact_with_a_lean_kicks_sideways_against_the_slip():
    """-i mu k_t u t_c/(m R), with the time of contact t_c, and a little more, since the rotor has weight."""
    rotor = pump(at=2, body=(MASS, 1e3, P["Jp"]))
    x = upright({"seat.mu": 0.2, "Omega": 500.0, "lower.enabled": 0.0, "upper.enabled": 0.0}, rotor)
    set_lateral(x, 0.0, 0.0, 1e-4, 0.0)
    for n in range(180):
        x.step(n * 50e-6, 50e-6)
    assert x["seat.mode"] == 0.0
    rate = np.sqrt(P["k"] / MASS)
    per_time = -0.2 * 0.5 * P["k"] * R * R * 1e-4 / (MASS * R)
    assert per_time * np.pi / rate == pytest.approx(-0.885e-3, rel=1e-3)
    kick = per_time * (np.pi + 2.0 * np.arctan(G / (np.sqrt(2.0 * G * GAP) * rate))) / rate
    v = memory(x).z[4:8]
    assert v[1] == pytest.approx(kick, rel=0.01)
    assert abs(v[0]) < 0.02 * abs(kick)


def kick_of(lean, e, mu=0.2):
    """Lateral velocity after an impact, mu/m times the integral of N c/R, integrated from touch to release by events.

    The ring touches from the penetration -a on, a = R u, and all around from a on; it leaves when N would pull.
    """
    a, d, k = R * lean, damping_of(e, P["k"], MASS), P["k"]

    def forces(z, speed):
        delta, rate = -z - GAP, -speed
        p = np.arccos(np.clip(-delta / a, -1.0, 1.0))
        normal = k * (delta * p + a * np.sin(p)) + d * rate * p
        moment = k * (delta * np.sin(p) + a * (p / 2.0 + np.sin(2.0 * p) / 4.0)) + d * rate * np.sin(p)
        return max(normal, 0.0) / np.pi, min(moment, max(normal, 0.0)) / np.pi, normal

    def rates(t, y):
        normal, moment, _ = forces(*y[:2])
        return [y[1], normal / MASS - G, mu / MASS * moment]

    def leaves(t, y):
        return forces(*y[:2])[2] if y[1] > 0.0 else 1.0

    leaves.terminal = True
    begin = [a - GAP, -np.sqrt(2.0 * G * (GAP - a)), 0.0]
    found = solve_ivp(rates, (0.0, 5e-3), begin, rtol=1e-9, atol=1e-14, max_step=2e-6, events=leaves)
    assert found.t_events[0].size == 1
    return found.y[2, -1]


@pytest.mark.parametrize("h", [50e-6, 10e-6])
@pytest.mark.parametrize(
    ("e", "lean", "of_seat"), [(0.3, 1e-5, 0.0), (0.3, 1e-4, 0.0), (0.7, 3e-5, 0.0), (0.2, 3e-6, 1.0)]
)
def test_an_impact_counts_the_time_in_which_one_side_of_the_ring_touches(h, e, lean, of_seat):
    """In these 1 to 40 us the dampers press on that side alone, which is up to a third of the kick."""
    rotor = pump(at=2, body=(MASS, 1e3, P["Jp"]))
    values = {"seat.mu": 0.2, "seat.restitution": e, "Omega": 500.0, "lower.enabled": 0.0, "upper.enabled": 0.0}
    x = upright(values | {"seat.seat_tilt_x": -of_seat * lean}, rotor)
    set_lateral(x, 0.0, 0.0, (1.0 - of_seat) * lean, 0.0)
    for n in range(round(9e-3 / h)):
        x.step(n * h, h)
    assert x["seat.mode"] == 0.0
    assert memory(x).z[5] == pytest.approx(-kick_of(lean, e), rel=3e-3)


@pytest.mark.parametrize("free", [0.0, 1.0], ids=["given speed", "free spin"])
def test_pieces_on_a_face_are_what_substeps_converge_to(free):
    """With a race, a mount that takes the friction, unbalance, and a seat whose tilt leans the rotor."""
    of_site = {"mu": 0.2, "race_inertia": 6e-6, "race_drag": 5e-3, "housing_mass": 0.15}
    of_site |= {f"mount_{name}_{a}": P[k] for name, k in (("stiffness", "km"), ("damping", "cm")) for a in "xy"}
    values = {f"{site}.{name}": value for site in ("lower", "upper") for name, value in of_site.items()}
    values |= {"seat.mu": 0.2, "seat.restitution": 0.5, "seat.on_mount": 1.0, "seat.seat_tilt_x": 2e-4}
    values |= {"spin.free": free, "spin.inertia": P["Jp"], "d1.u": 2e-5}
    ends, heats = [], []
    for exact in (1.0, 0.0):
        x = resting(values | {"solver.exact_motion": exact})
        x.step(0.0, 50e-6)
        methods, balance = [], x["energy.balance"]  # the ring was compressed by hand
        for n in range(1, 400):
            x.step(n * 50e-6, 50e-6)
            methods.append(x["solver.method"])
        assert methods.count(PIECES) >= 390 * exact
        assert abs(x["energy.balance"] - balance) < 1e-6 * x["seat.heat"]
        ends.append([x[name] for name in ("mb1.x", "mb1.y", "mb2.x", "mb2.y")])
        heats.append([x["seat.heat"], x["seat.torque"], x["lower.race_speed"], x["lower.heat"]])
    assert np.hypot(*ends[0][:2]) > 1e-2 * P["c0"]
    np.testing.assert_allclose(ends[0], ends[1], rtol=0.0, atol=1e-5 * P["c0"])
    np.testing.assert_allclose(heats[0], heats[1], rtol=1e-6)


def test_faces_out_of_reach_change_no_bit():
    rotor = replace(load_rotor(), thrust_disc=ThrustDisc(0.4))
    with_faces = replace(rotor, faces=(Face("seat", 1, "-z", 1e-3, 0.02), Face("stop", 1, "+z", 1e-3, 0.02)))
    names = ["mb1.x", "mb2.y", "rb1.f_n", "thrust.z", "energy.friction", "energy.work"]
    rub = BEARINGS | {"Omega": 260.0, "d1.u": 4e-2, "rb1.mu": 0.1, "thrust.f_z": 2.0}
    without, far = run(plant(rub, rotor), 200, names), run(plant(rub, with_faces), 200, names)
    assert 0.0 < without[-1, 3] < 1e-3
    np.testing.assert_array_equal(far, without)


def test_a_disabled_face_does_not_stop_the_rotor():
    x = upright({"seat.enabled": 0.0, "lower.enabled": 0.0, "upper.enabled": 0.0})
    run(x, 80)
    assert x["thrust.z"] == pytest.approx(-0.5 * G * (80 * H) ** 2, rel=1e-9)
    assert x["seat.gap"] < 0.0
    assert x["seat.mode"] == 0.0


def test_heat_of_a_face_warms_the_retainer_on_which_it_lands():
    x = landing({"mu": 0.2, "restitution": 0.3, "seat_tilt_x": 0.0, "housing_mass": 0.0, "race_inertia": 0.0})
    for name, value in {"lower.heat_capacity": 20.0, "lower.mu": 0.0, "upper.mu": 0.0}.items():
        x[name] = value
    for n in range(400):
        x.step(n * 50e-6, 50e-6)
    assert x["seat.heat"] > 5.0
    assert x["lower.heat"] == pytest.approx(x["seat.heat"], rel=0.01)
    assert x["lower.temperature"] - 293.15 == pytest.approx(x["lower.heat"] / 20.0, rel=1e-9)


def test_a_step_collects_each_such_output_of_a_face_and_a_new_start_forgets_it():
    check_collected(upright({"seat.mu": 0.1}), "seat", 200)
