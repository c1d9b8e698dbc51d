"""Friction and rolling: direction, size, symmetry, and the whirl speed of rolling without slip."""

import cmath
import math

import numpy as np
import pytest
from rotor_cases import (
    BEARINGS,
    CLEARANCE,
    H,
    OnePlane,
    bearing_positions,
    both,
    masters,
    place,
    plant,
    rigid_rotor,
    run,
    symmetric_rotor,
)

from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.enumerations import NEWTON, NODAL

ROTOR = load_rotor()
RING = 0.05
JOURNAL = 0.025
FORCES = ["rb1.f_n", "rb1.f_t", "rb2.f_n", "rb2.f_t"]
SLIPS = ["rb1.slip_velocity", "rb2.slip_velocity"]


@pytest.mark.parametrize(("Omega", "whirl"), [(100.0, 20.0), (-100.0, 20.0), (100.0, -20.0), (100.0, -60.0)])
def test_sliding_friction_is_mu_n_against_the_slip_and_changes_the_whirl(Omega, whirl):
    """dv/dt = T/m = -sign(slip) mu v^2/c, so v(t) = v0/(1 + sign(slip) mu v0 t/c)."""
    mu, steps = 0.2, 40
    x = plant(both("rb.clearance", RING) | both("rb.mu", mu) | {"Omega": Omega}, rigid_rotor(20.0))
    v0 = whirl * RING
    slip = Omega * JOURNAL + v0
    sign = math.copysign(1.0, slip)
    place(x, np.full(2, RING + 0j), np.full(2, 1j * v0), modes=(1, 1), signs=(sign, sign))
    record = run(x, steps, [*FORCES, *SLIPS, "rb1.whirl_speed", "rb1.mode", "energy.kinetic", "energy.dissipated"])
    assert np.all(record[:, 7] == 1)
    np.testing.assert_allclose(record[:, 1], -sign * mu * record[:, 0], rtol=1e-12)
    assert np.all(record[:, 1] * record[:, 4] < 0.0)
    t = H * np.arange(1, steps + 1)
    v = v0 / (1 + sign * mu * v0 * t / RING)
    np.testing.assert_allclose(record[:, 6] * RING, v, rtol=1e-6)
    np.testing.assert_allclose(record[:, 0], 10.0 * v**2 / RING, rtol=1e-6)
    drive = -20.0 * (v - v0) * JOURNAL * Omega  # work of the spin against friction, which is heat too
    np.testing.assert_allclose(record[:, 9], 0.5 * 20.0 * (v0**2 - v**2) + drive, rtol=1e-6)


@pytest.mark.parametrize("Omega", [80.0, -80.0])
def test_friction_drives_a_rigid_rotor_into_rolling_at_journal_over_gap(Omega):
    """Then whirl = -(R_s/c) Omega and N = m c whirl^2, without a friction force."""
    mu = 0.5
    x = plant(both("rb.clearance", RING) | both("rb.mu", mu) | {"Omega": Omega}, rigid_rotor(20.0))
    sign = math.copysign(1.0, Omega)
    v0 = -0.3 * JOURNAL * Omega  # whirls backward, too slowly to roll
    place(x, np.full(2, RING + 0j), np.full(2, 1j * v0), modes=(1, 1), signs=(sign, sign))
    names = ["rb1.mode", "rb2.mode", "rb1.whirl_speed", "rb1.f_n", "rb1.f_t", "rb1.slip_velocity", "energy.dissipated"]
    record = run(x, 2000, names)
    first = int(np.argmax(record[:, 0] == 2))
    # 1/|v| falls by mu/c per second from 1/|v0| to 1/(R_s |Omega|)
    expected = (1 / abs(v0) - 1 / abs(JOURNAL * Omega)) * RING / mu
    assert (first + 1) * H == pytest.approx(expected, abs=1.01 * H)
    rolling = record[first:]
    assert np.all(rolling[:, :2] == 2)
    whirl = -JOURNAL / RING * Omega
    np.testing.assert_allclose(rolling[:, 2], whirl, rtol=1e-9)
    np.testing.assert_allclose(rolling[:, 3], 10.0 * RING * whirl**2, rtol=1e-6)
    np.testing.assert_allclose(rolling[:, 4], 0.0, atol=1e-6)
    np.testing.assert_allclose(rolling[:, 5], 0.0, atol=1e-10)
    assert rolling[-1, 6] == pytest.approx(rolling[0, 6], rel=1e-12)


def stuck_under_load(value, mu, static=0.0, mode=2):
    """Journal at rest on the ring with a tangential load; the ring carries N = 900 N in steady state."""
    friction = both("rb.mu", mu) | both("rb.mu_static", static)
    x = plant(both("rb.clearance", RING) | friction | {"mb1.f_y": value, "mb2.f_y": value}, rigid_rotor(20.0))
    for k in (1, 2):
        x[f"mb{k}.f_x"] = 900.0
    return place(x, np.full(2, RING + 0j), np.zeros(2), modes=(mode, mode))


@pytest.mark.parametrize(("mu", "static", "mode"), [(0.2, 0.0, 2), (0.1, 0.2, 2), (0.0, 0.2, 1), (0.0, 0.2, 2)])
def test_stuck_journal_sticks_up_to_the_limit_of_its_friction(mu, static, mode):
    """Limit of sliding friction, or of static friction if that is larger; also if the initial mode is sliding."""
    x = stuck_under_load(160.0, mu, static, mode)
    record = run(x, 20, [*FORCES, "rb1.mode"])
    np.testing.assert_allclose(record[:, [0, 2]], 900.0, rtol=1e-9)
    np.testing.assert_allclose(record[:, [1, 3]], -160.0, rtol=1e-9)
    assert np.all(record[:, 4] == 2)


@pytest.mark.parametrize("load", [181.0, -181.0])
@pytest.mark.parametrize(("mu", "static"), [(0.2, 0.0), (0.1, 0.2)])
def test_journal_slides_under_more_than_its_friction_carries(mu, static, load):
    x = stuck_under_load(load, mu, static)
    record = run(x, 20, ["rb1.f_n", "rb1.f_t", "rb1.mode", "rb1.slip_velocity"])
    assert np.all(record[:, 2] == 1)
    sense = math.copysign(1.0, load)
    np.testing.assert_allclose(record[:, 1], -sense * mu * record[:, 0], rtol=1e-9)
    assert np.all(sense * np.diff(record[:, 3]) > 0.0)
    assert sense * record[0, 3] == pytest.approx(H * (181.0 - mu * 900.0) / 10.0, rel=1e-2)


def test_static_friction_below_that_of_sliding_changes_nothing():
    assert np.all(run(stuck_under_load(160.0, 0.2, static=0.05), 20, ["rb1.mode"]) == 2)


def rig(law, turn=0.0, mirrored=False, mu=0.3, **values):
    """The rig in hard contact: offsets, forces, unbalances and initial state turned by `turn`, or mirrored in x."""
    e = cmath.exp(1j * turn)

    def moved(z):
        z = np.asarray(z) * e
        return z.conj() if mirrored else z

    settings = BEARINGS | both("rb.mu", mu) | both("rb.restitution", 0.3) | {"contact.impact_law": law}
    settings |= {"Omega": -180.0 if mirrored else 180.0}
    for k, offset, force in ((1, 1e-4 - 5e-5j, 80 + 20j), (2, -3e-5 + 8e-5j, -40 + 60j)):
        settings[f"rb{k}.offset_x"], settings[f"rb{k}.offset_y"] = moved(offset).real, moved(offset).imag
        settings[f"mb{k}.f_x"], settings[f"mb{k}.f_y"] = moved(force).real, moved(force).imag
    for k, unbalance in ((1, 0.03 * cmath.exp(0.4j)), (3, 0.02 * cmath.exp(-2j))):
        settings[f"d{k}.u"] = abs(unbalance)
        settings[f"d{k}.phi"] = cmath.phase(complex(moved(unbalance)))
    settings |= {
        f"base.a_{axis}": getattr(complex(moved(2 - 3j)), part) for axis, part in (("x", "real"), ("y", "imag"))
    }
    settings |= {
        f"d2.f_{axis}": getattr(complex(moved(30 + 9j)), part) for axis, part in (("x", "real"), ("y", "imag"))
    }
    x = plant(settings | values)
    start = 1e-4 * np.array([1, 0.5j, 1 - 1j, 0.2, -0.5, 1j])
    return place(x, moved(start), moved(50j * start)), moved


@pytest.mark.parametrize("law", [NODAL, NEWTON])
@pytest.mark.parametrize(("turn", "mirrored"), [(math.pi / 2, False), (2.345, False), (0.0, True), (1.0, True)])
def test_rotated_or_mirrored_case_has_the_rotated_or_mirrored_motion(law, turn, mirrored):
    steps, sense = 160, -1.0 if mirrored else 1.0
    plain, _ = rig(law)
    other, moved = rig(law, turn, mirrored)
    names = [*FORCES, "rb1.mode", "rb2.mode", *SLIPS, "energy.dissipated"]
    a, b = (run(x, steps, names) for x in (plain, other))
    assert {1.0} <= set(a[:, 4]) | set(a[:, 5])
    assert np.max(a[:, [0, 2]]) > 100.0
    np.testing.assert_array_equal(a[:, 4:6], b[:, 4:6])
    scale = np.max(a[:, :4])
    np.testing.assert_allclose(b[:, [0, 2]], a[:, [0, 2]], atol=1e-5 * scale)
    np.testing.assert_allclose(b[:, [1, 3]], sense * a[:, [1, 3]], atol=1e-5 * scale)
    np.testing.assert_allclose(b[:, 8], a[:, 8], rtol=1e-5)
    np.testing.assert_allclose(masters(other)[0], moved(masters(plain)[0]), atol=1e-6 * CLEARANCE)


def test_swapped_ends_of_a_symmetric_rotor_swap_the_motion():
    def case(swap):
        a, b = (2, 1) if swap else (1, 2)
        values = BEARINGS | both("rb.mu", 0.2) | {"Omega": 150.0, f"rb{a}.offset_x": 1e-4, f"rb{b}.clearance": 0.6e-3}
        discs = {"d4.u": 0.04, "d2.u": 0.03, "d2.phi": 1.0} if swap else {"d1.u": 0.04, "d3.u": 0.03, "d3.phi": 1.0}
        x = plant(values | discs, symmetric_rotor())
        names = [f"rb{k}.{name}" for k in (a, b) for name in ("f_n", "f_t", "gap")]
        return run(x, 400, names), masters(x)[0]

    (plain, r), (swapped, s) = case(False), case(True)
    assert np.max(plain[:, 0]) > 100.0
    assert np.max(plain[:, 3]) > 100.0
    np.testing.assert_allclose(swapped, plain, atol=1e-5 * np.max(plain))
    np.testing.assert_allclose(s[::-1], r, atol=1e-6 * CLEARANCE)


@pytest.mark.parametrize("law", [NODAL, NEWTON])
def test_rig_with_mu_2_rolls_backward_at_3000_rad_per_s_and_100_kn(law):
    """90 rad/s, D1 94 g m, held against RB1 in +y at first, on springs along its orbit."""
    Omega, h = 90.0, 2e-5
    cycle = 2 * math.pi / Omega
    model = OnePlane.of(ROTOR, 1e6, 5000.0)
    orbit = model.orbit(Omega, [0.094, 0, 0, 0])
    journal = orbit[model.bearings[0]]
    values = BEARINGS | both("rb.mu", 2.0) | {"Omega": Omega, "d1.u": 0.094}
    x = plant(values | {"contact.impact_law": law, "solver.max_substep": h})
    place(x, orbit * 1j * CLEARANCE / journal, np.zeros(6), modes=(1, 0))
    record = run(x, round(0.6 * cycle / h), ["rb1.mode", "rb1.whirl_speed", *FORCES, "rb1.slip_velocity"], h=h)
    first = int(np.argmax(record[:, 0] == 2))
    assert 0.2 < (first + 1) * h / cycle < 0.3
    assert np.all(record[first:, 0] == 2)  # no way out
    np.testing.assert_allclose(record[first:, 1], -JOURNAL / CLEARANCE * Omega, rtol=1e-9)
    assert record[first:, 1].mean() == pytest.approx(-3000.0, rel=1e-9)
    np.testing.assert_allclose(record[first:, 6], 0.0, atol=1e-9)
    assert 0.8e5 < np.median(record[first:, 2]) < 2.5e5
    # the last contact began sliding; it rolls within a tenth of a cycle
    closed = record[:first, 0] > 0
    began = first - int(np.argmin(closed[::-1])) if not closed.all() else 0
    assert (first - began) * h < 0.1 * cycle
    for n, t in ((2, 3), (4, 5)):
        assert np.all(np.abs(record[:, t]) <= 2.0 * record[:, n] * (1 + 1e-9) + 1e-6)


@pytest.mark.parametrize("Omega", [220.0, 400.0])
def test_fast_rolling_is_accurate_for_any_longest_substep(Omega):
    """Whirl of 27500 and 50000 rad/s, many turns in one communication step: N = m c whirl^2, no slip, on the ring."""
    clearance, mass = 2e-4, 20.0
    x = plant(
        both("rb.clearance", clearance) | both("rb.mu", 1.0) | {"Omega": Omega, "solver.max_substep": 1e-3},
        rigid_rotor(mass),
    )
    whirl = -JOURNAL / clearance * Omega
    place(x, np.full(2, clearance + 0j), np.full(2, 1j * whirl * clearance), modes=(2, 2))
    record = run(x, 40, ["rb1.f_n", "rb1.whirl_speed", "rb1.mode"])
    np.testing.assert_allclose(record[:, 0], mass / 2 * clearance * whirl**2, rtol=1e-6)
    np.testing.assert_allclose(record[:, 1], whirl, rtol=1e-9)
    np.testing.assert_array_equal(record[:, 2], 2)
    turned = bearing_positions(x)[0] / clearance
    assert abs(turned - cmath.exp(1j * whirl * 40 * H)) < 1e-2
