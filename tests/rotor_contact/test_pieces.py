"""Which pieces of a step collocation may keep: those in which no site opens, slips or sticks, or leaves its circle."""

from functools import cache, partial

import numpy as np
import pytest
from rotor_cases import both, plant, scratch, size_of, workspace

from rotor_contact.contact.friction import STICK_SPEED
from rotor_contact.pieces.site_in_piece import MAX_DEVIATION
from rotor_contact.shaft.lobatto import LOBATTO_POINTS
from rotor_contact.variables.enumerations import ROLLING, SLIDING
from rotor_contact.whole_steps.collocation import _is_smooth
from rotor_contact.whole_steps.whole_step_rows import whole_step_of

CLEARANCE, CENTRE, MU = 4e-4, np.array([5e-5, -7e-5]), 0.3
OFFSETS = both("rb.offset_x", CENTRE[0]) | both("rb.offset_y", CENTRE[1])
rig = cache(partial(plant, both("rb.clearance", CLEARANCE) | OFFSETS))


class Piece:
    """A piece in which the first journal stays on its circle; N, T (N) and slip (m/s) are linear between its ends."""

    def __init__(self, mode, ends, mu=MU, sign=1.0, seed=0):
        rng = np.random.default_rng(seed)
        self.w, self.matrices = workspace(rig()), scratch(rig()).matrices
        self.matrices.sizes[0].n = size_of(rig())
        self.whole = whole_step_of(self.matrices, 0)
        self.w.sites["mode"] = 0
        site = self.w.sites[0]
        site.mode, site.slip_sign, site.mu, site.mu_static = mode, sign, mu, mu
        for node, s in zip(self.matrices.nodes[0], LOBATTO_POINTS, strict=True):
            node.f_n, node.f_t, node.slip = np.array(ends) @ (1.0 - s, s)
        self.whole.contact_response[0] = 1e-4 * rng.normal(size=16)
        angles = rng.uniform(0.0, 2.0 * np.pi, 4)
        self.directions = np.column_stack([np.cos(angles), np.sin(angles)])
        for point in (1, 2, 3):
            self.put(point, CLEARANCE)

    def put(self, point, radius):
        """Put the journal at a distance (m) from its centre at a Lobatto point."""
        at = 4 * point - 2
        place = CENTRE + radius * self.directions[point]
        self.whole.free_response[0, at : at + 2] = place - self.whole.contact_response[0, at : at + 2]

    def is_smooth(self):
        return _is_smooth(self.w, self.matrices, self.whole)


def random_ends(seed):
    """N, T and slip at both ends, of either sign."""
    rng = np.random.default_rng(seed)
    ends = rng.uniform(-0.3, 1.0, (3, 2))
    ends[1:] *= rng.choice([-1.0, 1.0])
    ends[1] *= 0.5 * MU
    return ends


@pytest.mark.parametrize("seed", range(40))
def test_rolling_lasts_a_piece_if_static_friction_suffices_throughout(seed):
    ends = random_ends(seed)
    suffices = np.min(ends[0]) > 0.0 and np.min(MU * ends[0] - np.abs(ends[1])) > 0.0
    assert Piece(ROLLING, ends, seed=seed).is_smooth() == suffices


@pytest.mark.parametrize("seed", range(40))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_sliding_lasts_a_piece_if_the_slip_keeps_its_sign(seed, sign):
    ends = random_ends(seed)
    lasts = np.min(ends[0]) > 0.0 and np.min(sign * ends[2]) > STICK_SPEED
    assert Piece(SLIDING, ends, sign=sign, seed=seed).is_smooth() == lasts


@pytest.mark.parametrize(("lowest", "lasts"), [(1e-9, True), (-1e-9, False)])
def test_a_piece_in_contact_ends_before_the_force_pulls(lowest, lasts):
    assert Piece(SLIDING, [[5.0, lowest], [0.0, 0.0], [1.0, 1.0]]).is_smooth() == lasts
    assert Piece(ROLLING, [[lowest, 5.0], [0.0, 0.0], [0.0, 0.0]]).is_smooth() == lasts


def test_slip_without_friction_may_change_its_sign():
    ends = [[5.0, 5.0], [0.0, 0.0], [1.0, -1.0]]
    assert Piece(SLIDING, ends, mu=0.0).is_smooth()
    assert not Piece(SLIDING, ends).is_smooth()


@pytest.mark.parametrize("point", [1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_journal_off_its_circle_at_an_inner_point_is_integrated(point, side):
    piece = Piece(SLIDING, [[5.0, 5.0], [0.0, 0.0], [1.0, 1.0]])
    for share, near in ((0.9, True), (1.1, False)):
        piece.put(point, CLEARANCE * (1.0 + side * share * MAX_DEVIATION))
        assert piece.is_smooth() == near
    piece.put(point, CLEARANCE)
    piece.put(3, 1.1 * CLEARANCE)  # the end is put on the circle by the smallest change
    assert piece.is_smooth()
