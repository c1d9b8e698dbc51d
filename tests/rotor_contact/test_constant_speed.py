"""Steps at a constant speed: matrices with the gradients of the magnets, and what differs from these at the nodes.

A speed that rises by 1e-9 rad/s^2 is constant for all purposes but this: its matrices are those of the grid, which are
exact at a speed that is built, and have no gradients.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from free_motion import WIDE
from rotor_cases import BEARINGS, H, both, head, memory, plant, run, scratch

from fmi_export.model import Instance
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.matrices.matrix_schedule import STEPS_BEFORE_BUILD
from rotor_contact.matrices.speed_grid import CONSTANT, STRIDE, spacing_for
from rotor_contact.shaft.structure import structure_of
from rotor_contact.variables.enumerations import EXACT, PIECES
from rotor_contact.whole_steps.constant_speed import PATIENCE

ELASTIC = load_rotor("bath_rig")
SEALED = replace(ELASTIC, seals=(Bearing("ring", 5, ((3e5, 5e4), (-5e4, 3e5)), ((400.0, 0.0), (0.0, 400.0))),))
ORBITS = [f"mb{k}.{axis}" for k, axis in product((1, 2), "xy")]
ENERGIES = ["energy.kinetic", "energy.damping", "energy.work"]
WATCHED = [*ORBITS, *ENERGIES, "energy.balance", "solver.method"]
BUILT_SPEED = 6.0 * STRIDE * spacing_for(H, structure_of(plant(WIDE, ELASTIC).constants).seals)  # rad/s
MEAN = np.array([3e5, 2.9e5, -4e5, -4e5])  # N/m, of x and y of both bearings
FAR = np.array([-2e5, -2e5, 1e5, 1.4e5])
FREE = WIDE | BEARINGS | {"Omega": BUILT_SPEED, "d1.u": 5e-4}
MOUNTS = both("rb.housing_mass", 3.0) | both("rb.race_inertia", 2.5e-4)
MOUNTS |= {f"rb{k}.mount_stiffness_{axis}": 1e7 for k, axis in product((1, 2), "xy")}
MOUNTS |= {f"rb{k}.mount_damping_{axis}": 1e4 for k, axis in product((1, 2), "xy")}
RUB = BEARINGS | both("rb.mu", 0.1) | {"Omega": BUILT_SPEED, "d1.u": 4e-2, "gravity": 9.81}
MACHINES = {
    "damped bearings": (FREE, ELASTIC),
    "seal": (FREE, SEALED),
    "mounts and races": (FREE | MOUNTS, ELASTIC),
    "contact": (RUB, ELASTIC),
}


def steps(x, count, first=0, mean=MEAN, swing=0.02, force=40.0):
    """Step under forces and gradients that vary around their mean, as those of nonlinear magnets; return a record."""
    record = np.empty((count, len(WATCHED)))
    for n in range(first, first + count):
        of_step = np.random.default_rng(n).uniform(-1.0, 1.0, 8)
        for axis, name in enumerate(("mb1.{}_x", "mb1.{}_y", "mb2.{}_x", "mb2.{}_y")):
            x[name.format("f")] = force * of_step[axis]
            x[name.format("k") + name[-1]] = mean[axis] * (1.0 + swing * of_step[4 + axis])
        record[n - first] = run(x, 1, WATCHED, start=n * H)[0]
    return record


def methods(record):
    return record[:, -1].astype(int)


def gradients(x):
    """Those in the matrices in use."""
    return scratch(x).matrices.gradients.copy()


def restored(x):
    """A fresh instance with the state of x, and nothing of its scratch."""
    fresh = Instance(x.model, x.constants)
    fresh.values[:] = x.values
    fresh.initialise()
    fresh.state[:] = x.state
    return fresh


def assert_same_motion(ours, expected, allowed):
    """Orbits, then energies; each relative to the largest."""
    for columns in (slice(0, 4), slice(4, 7)):
        largest = np.abs(expected[:, columns]).max()
        np.testing.assert_allclose(ours[:, columns], expected[:, columns], rtol=0.0, atol=allowed * largest)


@pytest.mark.parametrize("machine", MACHINES)
def test_gradients_in_the_matrices_act_as_those_at_the_nodes(machine):
    values, rotor = MACHINES[machine]
    ours, expected = plant(values, rotor), plant(values | {"Omega_dot": 1e-9}, rotor)
    records = [steps(x, 60) for x in (ours, expected)]
    assert np.max(np.abs(gradients(ours) - MEAN)) < 0.02 * np.max(np.abs(MEAN))
    assert not np.any(gradients(expected))
    touches = any(ours[f"rb{k}.f_n_peak"] > 0.0 for k in (1, 2)) or np.any(methods(records[0]) == PIECES)
    assert touches == (machine == "contact")
    assert np.all(methods(records[0])[1:] <= PIECES)
    orbits = [record[:, :4] for record in records]
    largest = np.abs(orbits[1]).max()
    np.testing.assert_allclose(*orbits, rtol=0.0, atol=(1e-6 if machine == "contact" else 1e-7) * largest)
    assert_same_motion(*records, 5e-6)  # at the nodes, torques of the damping are left to quadrature


def test_two_halves_of_a_step_are_the_step():
    """Under held forces and gradients the matrices of both are exact, at any speed."""
    whole, halves = (plant(FREE | MOUNTS | {"Omega": 263.7}, ELASTIC) for _ in range(2))
    for x in (whole, halves):
        steps(x, 1, swing=0.0)
    run(whole, 40)
    run(halves, 40, h=0.5 * H)
    memory(halves).z[:] = memory(whole).z
    head(halves).theta, head(halves).coupling = head(whole).theta, head(whole).coupling
    ours, expected = run(halves, 80, ORBITS, h=0.5 * H)[1::2], run(whole, 40, ORBITS)
    assert scratch(whole).matrices.sizes[0].place >= CONSTANT <= scratch(halves).matrices.sizes[0].place
    np.testing.assert_allclose(ours, expected, rtol=0.0, atol=1e-10 * np.abs(expected).max())


def test_magnets_that_change_are_not_integrated():
    """Their gradients are at the nodes until new matrices are complete; these have their mean."""
    ours, expected = plant(FREE, ELASTIC), plant(FREE | {"Omega_dot": 1e-9}, ELASTIC)
    steps(ours, 20), steps(expected, 20)
    wait = int(PATIENCE) + STEPS_BEFORE_BUILD
    record, other = (steps(x, wait, first=20, mean=FAR) for x in (ours, expected))
    assert np.max(np.abs(gradients(ours) - FAR)) < 0.02 * np.max(np.abs(FAR))
    assert np.all(methods(record) == EXACT)
    assert_same_motion(record, other, 1e-6)
    assert_same_motion(*(steps(x, 20, first=400, mean=FAR) for x in (ours, expected)), 1e-6)


@pytest.mark.parametrize(("machine", "strength"), [*((name, 1.0) for name in MACHINES), ("mounts and races", 30.0)])
def test_magnets_that_lost_their_power_exert_no_force(machine, strength):
    """The gradients in the matrices are still those of before; if they are strong, a step needs a piece."""
    values, rotor = MACHINES[machine]
    mean = strength * MEAN
    ours, expected = plant(values, rotor), plant(values | {"Omega_dot": 1e-9}, rotor)
    steps(ours, 20, mean=mean), steps(expected, 20, mean=mean)
    record, other = (steps(x, 40, first=20, mean=np.zeros(4), force=0.0) for x in (ours, expected))
    assert np.max(np.abs(gradients(ours) - mean)) < 0.02 * np.max(np.abs(mean))
    assert np.all(methods(record) <= PIECES)
    assert_same_motion(record, other, 5e-6)


def test_gradients_of_similar_axes_keep_an_isotropic_rotor_isotropic():
    x = plant(FREE, ELASTIC)
    steps(x, 5)
    found = gradients(x)
    assert found[0] == found[1]
    assert found[2] == found[3]
    assert scratch(x).matrices.sizes[0].isotropic == 1.0
    unlike = plant(FREE, ELASTIC)
    steps(unlike, 5, mean=np.array([3e5, 1e5, -4e5, -4e5]))
    assert gradients(unlike)[0] > 2.0 * gradients(unlike)[1]
    assert scratch(unlike).matrices.sizes[0].isotropic == 0.0


WAIT = int(PATIENCE)


@pytest.mark.parametrize("machine", ["damped bearings", "seal", "mounts and races", "contact"])
@pytest.mark.parametrize("at", [1, 10, 20 + WAIT // 2, 20 + WAIT + 16, 20 + WAIT + 50])
def test_a_restored_state_continues_to_the_last_bit(machine, at):
    """At the start, at constant gradients, while new ones are waited for, while matrices with them are built, after."""
    values, rotor = MACHINES[machine]
    x = plant(values, rotor)
    for n in range(at):
        steps(x, 1, first=n, mean=MEAN if n < 20 else FAR)
    fresh = restored(x)
    mean = MEAN if at < 20 else FAR
    np.testing.assert_array_equal(steps(fresh, 60, first=at, mean=mean), steps(x, 60, first=at, mean=mean))


def test_a_ramp_from_a_constant_speed_and_its_end_are_not_integrated():
    """The matrices of the grid are built when the speed starts to change; at its end they are used until others are."""
    x = plant(FREE, ELASTIC)
    steps(x, 40)
    assert scratch(x).matrices.sizes[0].place >= CONSTANT
    for n in range(40, 60):
        x["Omega"], x["Omega_dot"] = BUILT_SPEED + 40.0 * (n - 40) * H, 40.0
        assert methods(steps(x, 1, first=n))[0] == EXACT
    x["Omega"], x["Omega_dot"] = BUILT_SPEED + 40.0 * 20 * H, 0.0
    fresh = restored(x)
    for n in range(60, 60 + 40):
        ours, other = steps(x, 1, first=n), steps(fresh, 1, first=n)
        np.testing.assert_array_equal(other, ours)
        assert methods(ours)[0] == EXACT
        assert (scratch(x).matrices.sizes[0].place >= CONSTANT) == (n >= 60 + STEPS_BEFORE_BUILD)
