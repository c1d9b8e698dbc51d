"""Time and place of the first touch in straight flight, paths that may touch, and penetration."""

from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from rotor_cases import (
    BEARINGS,
    CLEARANCE,
    UNWATCHED,
    both,
    head,
    plant,
    rigid_rotor,
    run,
    shaft_only,
    size_of,
    workspace,
)

from fmi_export.model import Fault
from rotor_analysis.rotor import ReductionOptions
from rotor_contact.contact.workspace import stages_of
from rotor_contact.forces.dynamics import accelerations
from rotor_contact.substeps.event_time import EVENT_OFFSET, TOLERANCE, indicator, locate_event
from rotor_contact.substeps.integration import derivative, substep
from rotor_contact.substeps.substeps import largest_penetration, may_touch_between
from rotor_contact.variables.contact_laws import LAWS
from rotor_contact.variables.enumerations import FREE, SLIDING
from tests.support.messages import raises_naming

DT = 250e-6
CENTRES = np.array([1e-4 - 5e-5j, -7e-5 + 0j])
OFFSETS = {f"rb{k}.offset_x": c.real for k, c in enumerate(CENTRES, 1)}
OFFSETS |= {f"rb{k}.offset_y": c.imag for k, c in enumerate(CENTRES, 1)}
rig = cache(partial(plant, OFFSETS, rigid_rotor(20.0)))
pressed = cache(partial(plant, OFFSETS | both("rb.mu", 0.1), rigid_rotor(20.0)))
moving = cache(partial(plant, OFFSETS | both("rb.housing_mass", 2.0), rigid_rotor(20.0)))


def flying(r, v, instance=rig, modes=(FREE, FREE)):
    """The kernels' workspace with both journals at r (m from the centres of their retainers) and velocities v."""
    w = workspace(instance())
    stages, n = stages_of(w.stages), size_of(instance())
    stages.z[:] = 0.0
    for i, values in ((0, np.asarray(r) + CENTRES), (w.n, np.asarray(v, complex))):
        stages.z[i : i + n] = np.ravel(np.column_stack([np.real(values), np.imag(values)]))
    w.sites["mode"][:2] = modes
    assert derivative(w, 0.0, stages.z, stages.k_1)
    return w


def touch_of(r, v):
    """Time at which a point in straight flight is at the clearance."""
    a, b, c = abs(v) ** 2, (r * np.conj(v)).real, abs(r) ** 2 - CLEARANCE**2
    return (-b + np.sqrt(b * b - a * c)) / a


def random_flight(seed):
    """Journals anywhere in their clearances, of which none, one or both touch within DT."""
    rng = np.random.default_rng(seed)
    r = CLEARANCE * rng.uniform(0.0, 0.95, 2) * np.exp(2j * np.pi * rng.uniform(size=2))
    v = rng.uniform(0.2, 8.0, 2) * np.exp(2j * np.pi * rng.uniform(size=2))
    return r, v, np.array([touch_of(*flight) for flight in zip(r, v, strict=True)])


@pytest.mark.parametrize("seed", range(40))
def test_the_first_touch_is_at_the_time_of_straight_flight(seed):
    r, v, times = random_flight(seed)
    w = flying(r, v)
    assert substep(w, 0.0, DT)
    if min(times) > DT:
        assert indicator(w.sites, stages_of(w.stages).z_new, w.n, 0.0) < 0.0
        return
    assert locate_event(w, 0.0, DT) == pytest.approx(min(times), abs=1e-10 * DT)
    assert is_at_an_event(w, 0.0)


def is_at_an_event(w, Omega):
    z_new = stages_of(w.stages).z_new
    return abs(indicator(w.sites, z_new, w.n, Omega) - EVENT_OFFSET) < EVENT_OFFSET - TOLERANCE


def test_an_absent_journal_does_not_touch():
    w = flying([0j, 0j], [8.0, 1.0])
    w.sites["enabled"][0] = 0.0
    assert substep(w, 0.0, DT)
    assert indicator(w.sites, stages_of(w.stages).z_new, w.n, 0.0) < 0.0


@pytest.mark.parametrize("seed", range(20))
def test_penetration_is_the_deepest_of_free_journals_at_rigid_retainers(seed):
    rng = np.random.default_rng(seed)
    r = CLEARANCE * rng.uniform(0.9, 1.3, 2) * np.exp(2j * np.pi * rng.uniform(size=2))
    w = flying(r, [0j, 0j])
    w.sites["law"][rng.integers(2)] = rng.choice([0, LAWS.index("hertz")])
    w.sites["mode"][rng.integers(2)] = rng.choice([FREE, SLIDING])
    counted = [abs(r[k]) / CLEARANCE - 1.0 for k in range(2) if w.sites[k].law == 0 and w.sites[k].mode == FREE]
    assert largest_penetration(w.sites, stages_of(w.stages).z) == pytest.approx(max(0.0, *counted, 0.0), abs=1e-12)


def path(w, begin, end):
    """Let the second journal be where and as fast as these say at both ends of a substep."""
    stages, n = stages_of(w.stages), w.n
    for z, (r, v) in ((stages.z, begin), (stages.z_new, end)):
        z[:] = 0.0
        z[2:4], z[n + 2 : n + 4] = (r.real + CENTRES[1].real, r.imag + CENTRES[1].imag), (v.real, v.imag)
        z[0:2] = CENTRES[0].real, CENTRES[0].imag
    return w


FAR, C = 0.9 * CLEARANCE + 0j, CLEARANCE + 0j
PATHS = {
    "it stays near the centre": ((0j, 1.0 + 0j), (2e-4 + 0j, 1.0 + 0j), False),
    "it goes out and comes back": ((FAR, 4.0 + 0j), (FAR, -4.0 + 0j), True),
    "it ends beyond": ((FAR, 1.0 + 0j), (1.1 * FAR / 0.9, 1.0 + 0j), True),
    "it leaves the circle inwards": ((C, -1.0 + 0j), (C - 2e-4, -1.0 + 0j), False),
    "it leaves the circle along it": ((C, 1j), (C * np.exp(0.3j) - 3e-5, 1j * np.exp(0.3j) - 0.2), False),
    "it leaves the circle and comes back": ((C, -4.0 + 0j), (C, 4.0 + 0j), True),
}


@pytest.mark.parametrize(("begin", "end", "may"), PATHS.values(), ids=PATHS)
def test_a_path_may_touch_unless_it_stays_inside_or_leaves(begin, end, may):
    w = path(flying([0j, 0j], [0j, 0j]), begin, end)
    assert may_touch_between(w, DT) == may
    w.sites["enabled"][1] = 0.0
    assert not may_touch_between(w, DT)


def test_a_path_that_leaves_a_housing_that_moves_may_touch_it():
    begin, end, may = PATHS["it leaves the circle inwards"]
    w = path(flying([0j, 0j], [0j, 0j], moving), begin, end)
    assert not may
    assert may_touch_between(w, DT)


def slowing(r, v, Omega=0.02, Omega_dot=-160.0):
    """A substep in which the first journal slides under a small normal force: 1e-2 N on 10 kg hardly move it."""
    w = flying(r, v, pressed, modes=(SLIDING, FREE))
    w = w._replace(motion=w.motion._replace(Omega=Omega, Omega_dot=Omega_dot))
    w.sites["slip_sign"][0] = 1.0
    accelerations(w.motion).steady[0] = 1e-3
    stages = stages_of(w.stages)
    assert derivative(w, 0.0, stages.z, stages.k_1)
    assert w.sites["f_n"][0] == pytest.approx(1e-2)
    assert substep(w, 0.0, DT)
    assert indicator(w.sites, stages.z_new, w.n, Omega + Omega_dot * DT) > TOLERANCE
    return w


def test_slip_that_a_falling_speed_reverses_vanishes_when_the_speed_does():
    w = slowing([C, 0j], [0j, 0j])
    located = locate_event(w, 0.0, DT)
    assert located == pytest.approx(0.02 / 160.0, rel=1e-3)
    assert is_at_an_event(w, 0.02 - 160.0 * located)


@pytest.mark.parametrize("gap", [1e-7, 1e-9, 1e-11])
def test_slip_vanishes_while_another_journal_flies_close_by(gap):
    """The other flies up to this part of the clearance within its circle, which it left at the beginning."""
    flight = 255e-6
    inward = 4.0 * gap * CLEARANCE / flight
    w = slowing([C, (1.0 - 1e-13) * C], [0j, complex(-inward, np.sqrt(2.0 * CLEARANCE * inward / flight))])
    located = locate_event(w, 0.0, DT)
    assert located == pytest.approx(0.02 / 160.0, rel=1e-3)
    assert is_at_an_event(w, 0.02 - 160.0 * located)


def halvings(tolerance, steps):
    """Return how often substeps are halved in some steps of an orbiting rotor, and whether that is insufficient."""
    orbit = {"d1.u": 0.02, "Omega": 300.0, "solver.exact_motion": 0.0, "solver.tolerance": tolerance}
    x = plant(BEARINGS | orbit)
    result = []
    for n in range(steps):
        x.step(n * DT, DT)
        result.append(float(head(x).n_halvings))
    return result, bool(head(x).tolerance_missed)


def test_substeps_are_halved_only_as_often_as_the_tolerance_requires():
    counts_at = {tolerance: halvings(tolerance, 40) for tolerance in np.logspace(-15.0, 0.0, 31)}
    often = [counts[-1] for counts, _ in counts_at.values()]
    assert often == sorted(often, reverse=True)
    assert set(often) == {0.0, 1.0, 2.0}
    assert counts_at[1e-15] == ([2.0] * 40, True)
    assert counts_at[1.0] == ([0.0] * 40, False)
    assert any(set(counts[10:]) == {1.0} for counts, _ in counts_at.values()), "it goes to and fro"


def test_more_bounces_in_a_step_than_can_be_followed_are_a_fault():
    """Beyond fifty events a step continues in two-hundredths, in which a journal may penetrate deeply."""
    bouncing = BEARINGS | both("rb.restitution", 0.9) | {"Omega": 260.0, "d1.u": 0.04, "d4.u": 0.04}
    with raises_naming(Fault, "contact events"):
        plant(bouncing).step(0.0, 0.2)
    x = plant(bouncing)
    for n in range(800):
        x.step(n * DT, DT)


def needlessly_stiff(masters, **values):
    """A thick shaft of half a metre that whirls in its retainers; 21 planes have a mode of 38 kHz."""
    rotor = replace(shaft_only(np.linspace(0.0, 0.5, 21), 0.1), reduction=ReductionOptions(masters=masters))
    rubs = both("rb.restitution", 0.5) | both("rb.mu", 0.1) | both("rb.clearance", 1e-4) | both("mb.c_b", 500.0)
    return plant(BEARINGS | rubs | UNWATCHED | {"Omega": 1000.0, "d1.u": 1e-3, "d2.u": 1e-3} | values, rotor)


def test_fault_of_stiff_modes_advises_shorter_substeps_or_fewer_modes():
    """The integration of its fastest mode is unstable; either remedy stabilises it."""
    long = {"solver.max_substep": 1e-4}
    x = needlessly_stiff(tuple(range(1, 22)), **long)
    start = x.model.interface["solver.max_substep"].start
    with raises_naming(Fault, "contact events", f"{2.5 * start:.3g} s", "0.0001 s"):
        run(x, 80)
    run(needlessly_stiff(tuple(range(1, 22))), 80)
    run(needlessly_stiff((1, 21), **long), 80)
