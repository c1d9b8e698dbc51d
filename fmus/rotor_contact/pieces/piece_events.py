"""The first contact event in a solved piece, from its series and from the cubics of its forces.

    free         gap closes             |r| = c
    constrained  normal force vanishes  N = 0
                 slip vanishes          v_slip = 0, if it slides
                 friction too small     |T| = mu_s N, if it rolls

A slow touch or a graze that lasts less than a sixteenth of the piece does not count as an event.
"""

from __future__ import annotations

import math

from fmi_export.jit import kernel, noinline_kernel
from rotor_contact.contact.friction import STICK_SPEED, friction_limit, has_friction
from rotor_contact.contact.path import Point, leaves_or_stays_within
from rotor_contact.contact.site import Site, can_touch, is_constrained
from rotor_contact.contact.site_totals import Nodes
from rotor_contact.contact.workspace import Workspace
from rotor_contact.matrices.step_matrices import StepMatrices
from rotor_contact.pieces.piece_series import expand, journal_at, slip_at
from rotor_contact.shaft.lobatto import first_fall
from rotor_contact.variables.enumerations import ROLLING

NEVER = 2.0  # share of the piece that stands for no event
N_LOOKS, N_FINE_LOOKS = 16, 4  # for a touch in the piece, and between two of these
BEYOND = 1e-11  # of the clearance, by which a journal that touches has passed its circle
TOUCH_EXPECTED = 0.05  # share of a piece after the first possible touch, within which most touches occur
LEAST_PULL = 5e-4  # of the largest force in the piece; a smaller tension, within the cubic's error, releases no journal
MOST_TRIALS = 60  # for the time of an event
SLIP_LEFT = 0.5 * STICK_SPEED  # m/s, in the new direction, at the reversal of slip
FARTHEST = 1e-2  # share of the piece by which the cubic of slip may miss its reversal
LEAST_SHARE = 1e-15  # of the piece, by which an event is located


@noinline_kernel
def find_event(
    w: Workspace, matrices: StepMatrices, index: float, h: float, share: float, latest: float
) -> tuple[int, float]:
    """Expand a solved piece of length h (s) up to its first event; return the number of terms and the event's share.

    There is no event before `share`. If there is none before the share `latest` either, the result is `NEVER`, and the
    series reaches `latest`. If the series has too few terms for this, the number returned is 0. `index` is the position
    of the speed on the grid.
    """
    event = _end_of_modes(w, matrices) if share < latest else NEVER
    end, n_terms = min(event, latest), 0
    for reach in (min(end, share + TOUCH_EXPECTED), end):
        n_terms = expand(w, matrices, index, h, reach)
        if n_terms == 0:
            return 0, NEVER
        touch = _first_touch(w, matrices, n_terms, h, share, reach)
        if touch <= reach:
            return n_terms, touch
        if reach == end:
            break
    return n_terms, _end_of_slip(w, matrices, n_terms, event) if event <= latest else NEVER


@kernel
def _end_of_modes(w: Workspace, matrices: StepMatrices) -> float:
    """Return the share of a piece at which the first constrained site opens, sticks or slips, or `NEVER` if none does.

    The share follows from the cubics through the Lobatto points; the cubic of the slip is approximate (`_end_of_slip`).
    """
    first = NEVER
    for k in range(w.sites.shape[0]):
        if is_constrained(w.sites[k]):
            first = min(first, _end_of_mode(w.sites[k], matrices.nodes[k]))
    return first


@kernel
def _first_touch(w: Workspace, matrices: StepMatrices, n_terms: int, h: float, earliest: float, latest: float) -> float:
    """Return the share of a piece of length h (s) at which a journal first touches; `NEVER` if none does by `latest`.

    No journal touches before the share `earliest`. Requires the series of the piece, which has `n_terms` terms.
    """
    first = NEVER
    for site in w.sites:
        if can_touch(site):
            first = min(first, _touch(matrices, site, n_terms, h, earliest, min(first, latest)))
    return first


@kernel
def _touch(matrices: StepMatrices, site: Site, n_terms: int, h: float, earliest: float, latest: float) -> float:
    """Return the share of the piece at which a free journal reaches its circle; `NEVER` if it does not by `latest`."""
    if earliest >= latest:
        return NEVER
    n_looks = math.ceil((latest - earliest) * N_LOOKS)
    begin, length = journal_at(matrices, n_terms, earliest, site), (latest - earliest) / n_looks
    for look in range(1, n_looks + 1):
        low, high, dt = earliest + length * (look - 1), earliest + length * look, h * length
        end = journal_at(matrices, n_terms, high, site)
        if not leaves_or_stays_within(site, begin, end, dt, 0.0):
            for fine in range(1, N_FINE_LOOKS + 1):
                at = low + (high - low) * fine / N_FINE_LOOKS
                if _gap(site, journal_at(matrices, n_terms, at, site)) > 0.0:
                    return _touch_between(matrices, site, n_terms, h, low, at)
        begin = end
    return NEVER


@kernel
def _gap(site: Site, journal: Point) -> float:
    """Return how far (m) a journal is beyond the radius from which it counts as touching."""
    return math.sqrt(journal.x * journal.x + journal.y * journal.y) - (1.0 + BEYOND) * site.clearance


@kernel
def _touch_between(matrices: StepMatrices, site: Site, n_terms: int, h: float, low: float, high: float) -> float:
    """Return the share at which a journal reaches its circle (Newton); it is inside at `low` and beyond at `high`."""
    s = high
    for _ in range(MOST_TRIALS):
        journal = journal_at(matrices, n_terms, s, site)
        beyond = _gap(site, journal)
        low, high = (low, s) if beyond > 0.0 else (s, high)
        rate = h * (journal.x * journal.v_x + journal.y * journal.v_y) / (site.clearance + beyond)
        last, s = s, s - beyond / rate if rate > 0.0 else low
        if not low < s < high:
            s = 0.5 * (low + high)
        if abs(s - last) <= LEAST_SHARE:
            break
    return s


@kernel
def _end_of_mode(site: Site, nodes: Nodes) -> float:
    """Return the share of the piece at which a constrained site opens, sticks or slips, or `NEVER` if it does not."""
    a, b, c, d = nodes[0], nodes[1], nodes[2], nodes[3]
    pull = LEAST_PULL * max(max(abs(a.f_n), abs(b.f_n)), max(abs(c.f_n), abs(d.f_n)))
    first: float = first_fall(a.f_n + pull, b.f_n + pull, c.f_n + pull, d.f_n + pull)
    if site.mode == ROLLING:
        limit_a, limit_b = friction_limit(site, a.f_n) + pull, friction_limit(site, b.f_n) + pull
        limit_c, limit_d = friction_limit(site, c.f_n) + pull, friction_limit(site, d.f_n) + pull
        for sign in (1.0, -1.0):
            slips = first_fall(
                limit_a - sign * a.f_t, limit_b - sign * b.f_t, limit_c - sign * c.f_t, limit_d - sign * d.f_t
            )
            first = min(first, slips)
    elif has_friction(site):
        s, rest = site.slip_sign, SLIP_LEFT
        first = min(
            first, first_fall(max(s * a.slip, 0.0) + rest, s * b.slip + rest, s * c.slip + rest, s * d.slip + rest)
        )
    return first


@kernel
def _end_of_slip(w: Workspace, matrices: StepMatrices, n_terms: int, near: float) -> float:
    """Return the share close to `near` at which a sliding site's slip reverses (secant), or `near` if none is found.

    Requires the series of the piece, which has `n_terms` terms, up to this share.
    """
    for k in range(w.sites.shape[0]):
        site = w.sites[k]
        if is_constrained(site) and site.mode != ROLLING and has_friction(site):
            before, at, sign = 0.0, near, site.slip_sign
            f, now = max(sign * matrices.nodes[k, 0].slip, 0.0) + SLIP_LEFT, 0.0
            for _ in range(MOST_TRIALS):
                now = sign * slip_at(matrices, site, k, n_terms, at) + SLIP_LEFT
                if abs(now) <= 0.5 * SLIP_LEFT or now == f or abs(at - near) > FARTHEST:
                    break
                before, at, f = at, at - now * (at - before) / (now - f), now
            if abs(now) <= 0.5 * SLIP_LEFT and at > 0.0:
                return at
    return near
