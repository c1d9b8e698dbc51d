"""Pieces that end on an event: the series of their motion, the time of the event, and the energies of the part."""

import numpy as np
import pytest
from rotor_cases import both, plant, run, scratch, state, workspace

from rotor_analysis.rotor_file import load_rotor
from rotor_contact.contact.path import Point
from rotor_contact.contact.site import locate_journal, radial_component, slip_velocity
from rotor_contact.contact.workspace import stages_of
from rotor_contact.matrices.speed_grid import place_on_grid
from rotor_contact.matrix_step import find_forces_at
from rotor_contact.pieces.piece import piece_of
from rotor_contact.pieces.piece_cut import cut_piece
from rotor_contact.pieces.piece_energy import damping_in_piece
from rotor_contact.pieces.piece_series import expand, journal_at, state_at
from rotor_contact.pieces.piece_solution import begin_piece, complete_forces, end_piece, solve_piece
from rotor_contact.shaft.lobatto import LOBATTO_POINTS, first_fall, restrict
from rotor_contact.variables.enumerations import EXACT, PIECES, ROLLING

ELASTIC = load_rotor("bath_rig")
STEP, LEVEL = 250e-6, 3
FALL = both("rb.mu", 0.12) | {"gravity": 9.81, "Omega": 260.0, "d1.u": 5e-4, "spin.free": 1.0}
MOUNTED = both("rb.housing_mass", 3.0) | both("rb.mount_stiffness_x", 1e7) | both("rb.mount_damping_x", 1e4)
MOUNTED |= both("rb.mount_stiffness_y", 1e7) | both("rb.mount_damping_y", 1e4)
CASES = {"free spin": {}, "mounts": MOUNTED, "given speed": {"spin.free": 0.0, "Omega_dot": 50.0}}
ROLLS = both("rb.mu", 0.3) | both("rb.race_inertia", 2.5e-4) | both("rb.race_drag", 0.02) | {"Omega": 60.0}


class SolvedPiece:
    """A solved piece of 31.25 us of a rotor that has fallen into its retainers, with the end by its matrices."""

    def __init__(self, case):
        x = plant(FALL | CASES[case], ELASTIC)
        run(x, 240, h=STEP)
        while not (x["rb1.mode"] and x["rb1.f_n"] > 0.0):
            run(x, 1, h=STEP)
        self.h, self.Omega = STEP * 0.5**LEVEL, x["speed"]
        self.w, self.matrices = workspace(x, self.Omega), scratch(x).matrices
        self.z, self.z_new = stages_of(self.w.stages).z, stages_of(self.w.stages).z_new
        self.z[: 2 * self.w.n] = state(x)[: 2 * self.w.n]
        self.index = place_on_grid(self.matrices, self.Omega)
        holds, torque = find_forces_at(self.w, self.matrices, self.z, 0.0, self.Omega)
        assert holds
        begin_piece(self.w, self.matrices, LEVEL, self.index)
        assert solve_piece(self.w, self.matrices, LEVEL, self.index, self.h, 0.0, self.Omega, torque)
        complete_forces(self.matrices)
        assert end_piece(self.w, self.matrices, LEVEL, self.index, self.h)
        self.n = int(self.matrices.sizes[0].n)
        self.end = np.concatenate([self.z_new[: self.n], self.z_new[self.w.n : self.w.n + self.n]])
        self.of_damping = damping_in_piece(self.w, self.matrices, LEVEL, self.index)
        self.n_terms = expand(self.w, self.matrices, self.index, self.h, 1.0)


@pytest.fixture(params=CASES)
def piece(request):
    return SolvedPiece(request.param)


def test_taylor_series_of_a_piece_ends_with_its_matrices(piece):
    y = np.empty(2 * piece.n)
    state_at(piece.matrices, piece.n_terms, 1.0, y)
    for part in (slice(piece.n), slice(piece.n, None)):
        np.testing.assert_allclose(y[part], piece.end[part], atol=1e-6 * np.max(np.abs(piece.end[part])))


def test_velocity_of_a_journal_is_the_rate_of_its_displacement(piece):
    site, ds = piece.w.sites[0], 1e-3
    before, at, after = (Point(*journal_at(piece.matrices, piece.n_terms, s, site)) for s in (0.4 - ds, 0.4, 0.4 + ds))
    speed = np.hypot(at.v_x, at.v_y)
    assert (after.x - before.x) / (2.0 * ds * piece.h) == pytest.approx(at.v_x, abs=1e-5 * speed)
    assert (after.y - before.y) / (2.0 * ds * piece.h) == pytest.approx(at.v_y, abs=1e-5 * speed)


def test_work_of_dampers_over_a_cut_is_the_quadratic_form(piece):
    """Gauss's quadrature of the power over the series, and the form built by doubling, share no code."""
    of_damping = cut_piece(piece.w, piece.matrices, piece.index, piece.n_terms, piece.h, 1.0, False)
    assert piece.of_damping.heat > 0.0
    assert of_damping.heat == pytest.approx(piece.of_damping.heat, rel=1e-5)
    assert of_damping.impulse == pytest.approx(piece.of_damping.impulse, rel=1e-5)


@pytest.mark.parametrize("share", [0.35, 1.0])
def test_slip_over_a_cut_is_that_of_the_motion_at_its_points(piece, share):
    """The heat of friction comes from it. The spin turns as over the whole piece."""
    y, site = np.empty(2 * piece.n), piece.w.sites[0]
    spin = piece_of(piece.matrices).spin[0].copy()
    cut_piece(piece.w, piece.matrices, piece.index, piece.n_terms, piece.h, share, False)
    for point in range(1, len(LOBATTO_POINTS)):
        at = share * LOBATTO_POINTS[point]
        state_at(piece.matrices, piece.n_terms, at, y)
        q, v = np.zeros(piece.w.n), np.zeros(piece.w.n)
        q[: piece.n], v[: piece.n] = np.split(y, 2)
        locate_journal(site, q)
        speed = np.polyval(np.polyfit(LOBATTO_POINTS, spin, 3), at)
        if site.spin >= 0:
            v[site.spin] = speed
        assert piece.matrices.nodes[0, point].slip == pytest.approx(slip_velocity(site, v, speed), rel=1e-9)


@pytest.mark.parametrize("seed", range(10))
def test_first_falling_root_of_a_cubic_is_located(seed):
    roots = np.cumsum(np.random.default_rng(seed).uniform(0.1, 0.6, 3))
    falling = np.polyval(-np.poly(roots), LOBATTO_POINTS)  # positive before the first root
    assert first_fall(*falling) == pytest.approx(roots[0] if roots[0] <= 1.0 else 2.0, abs=1e-12)
    assert first_fall(*(falling - np.min(falling) + 10.0)) == 2.0


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_restricted_cubic_has_the_values_of_the_whole(share):
    coefficients = [2.0, -3.0, 0.5, 1.0]
    values = np.polyval(coefficients, LOBATTO_POINTS)
    restrict(values, share)
    np.testing.assert_allclose(values, np.polyval(coefficients, share * np.array(LOBATTO_POINTS)), atol=1e-13)


@pytest.mark.parametrize("case", [*CASES.values(), ROLLS], ids=[*CASES, "rolling that ends at its limit of friction"])
def test_contact_events_need_no_substeps(case):
    x = plant(FALL | case, ELASTIC)
    run(x, 40, h=STEP)  # until the matrices are built
    record = run(x, 360, ["solver.method", "rb1.impulse", "rb2.impulse"], h=STEP)
    assert np.count_nonzero(record[:, 1:]) >= 3
    assert set(record[:, 0]) <= {EXACT, PIECES}
    assert set(record[np.any(record[:, 1:], axis=1), 0]) == {PIECES}


@pytest.mark.parametrize("case", [*CASES.values(), ROLLS], ids=[*CASES, "rolling"])
def test_contact_keeps_gap_and_slip_closed_at_the_ends_of_steps(case):
    x, largest = plant(FALL | case, ELASTIC), np.zeros(3)
    run(x, 40, h=STEP)
    for _ in range(200):
        run(x, 1, h=STEP)
        w = workspace(x, x["speed"])
        q, v = np.split(state(x)[: 2 * w.n], 2)
        for site in w.sites:
            if site.mode:
                off = locate_journal(site, q) / site.clearance - 1.0, radial_component(site, v), 0.0
                if site.mode == ROLLING:
                    off = *off[:2], slip_velocity(site, v, x["speed"])
                largest = np.maximum(largest, np.abs(off))
    assert np.all(largest < [1e-12, 1e-8, 1e-9])
