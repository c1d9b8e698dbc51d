"""Unbalances, forces and the base change from step to step: the matrices for unit inputs serve them all."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from free_motion import WIDE
from rotor_cases import BEARINGS, H, both, plant, run, scratch

from fmi_export.model import Instance
from rotor_analysis.parts import Bearing
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.variables.enumerations import EXACT, NO_MATRICES, PIECES

ELASTIC = load_rotor("bath_rig")
SEALED = replace(ELASTIC, seals=(Bearing("ring", 5, ((3e5, 5e4), (-5e4, 3e5)), ((400.0, 0.0), (0.0, 400.0))),))
UNLIKE = replace(ELASTIC, seals=(Bearing("ring", 5, ((3e5, 0.0), (0.0, 1e5)), ((400.0, 0.0), (0.0, 900.0))),))
MOUNTS = both("rb.housing_mass", 3.0) | both("rb.race_inertia", 2.5e-4)
MOUNTS |= {f"rb{k}.mount_stiffness_{axis}": 1e7 for k, axis in product((1, 2), "xy")}
MOUNTS |= {f"rb{k}.mount_damping_{axis}": 1e4 for k, axis in product((1, 2), "xy")}
FREE = WIDE | BEARINGS | {"Omega": 263.7, "d1.u": 5e-4, "gravity": 9.81, "gravity_angle": 0.7}
MACHINES = {
    "damped bearings": (FREE, ELASTIC),
    "seal": (FREE, SEALED),
    "unlike axes": (FREE, UNLIKE),
    "mounts": (FREE | MOUNTS, ELASTIC),
    "speed ramp": (FREE | {"Omega_dot": 100.0}, ELASTIC),
    "free spin": (FREE | MOUNTS | {"spin.free": 1.0}, ELASTIC),
}
LARGEST = {"d1.u": 1e-3, "d3.u": 1e-3, "mb2.u": 1e-3, "d1.phi": 3.0, "d2.f_x": 90.0, "d4.f_y": 90.0}
LARGEST |= {"mb1.phi": 3.0, "mb1.u": 1e-3, "base.a_x": 2.0, "base.a_y": 2.0, "gravity_angle": 3.0}
MOTION = [f"mb{k}.{axis}" for k, axis in product((1, 2), "xy")]
ENERGIES = ["energy.damping", "energy.work", "energy.kinetic"]
WATCHED = [*MOTION, *ENERGIES, "energy.balance", "solver.method"]


def steps(x, count, first=0, names=tuple(LARGEST)):
    """Step with inputs that change in every step; return a record."""
    record = np.empty((count, len(WATCHED)))
    for n in range(first, first + count):
        for name, share in zip(LARGEST, np.random.default_rng(n).uniform(0.0, 1.0, len(LARGEST)), strict=True):
            if name in names:
                x[name] = share * LARGEST[name]
        record[n - first] = run(x, 1, WATCHED, start=n * H)[0]
    return record


@pytest.mark.parametrize("machine", MACHINES)
def test_changed_inputs_agree_with_short_substeps(machine):
    values, rotor = MACHINES[machine]
    values = values | {"solver.energy_limit": 1e9}
    ours = steps(plant(values, rotor), 80)
    assert np.all(ours[1:, -1] <= PIECES)
    expected = steps(plant(values | {"solver.exact_motion": 0, "solver.max_substep": 7.5e-6}, rotor), 80)
    for columns, allowed in ((slice(0, 4), 1e-6), (slice(4, 7), 1e-5)):
        largest = np.abs(expected[:, columns]).max()
        np.testing.assert_allclose(ours[:, columns], expected[:, columns], rtol=0.0, atol=allowed * largest)
    assert np.abs(ours[:, 7]).max() < 1e-6 * np.abs(expected[:, 4:7]).max()


@pytest.mark.parametrize("name", LARGEST)
def test_each_input_changes_without_substeps(name):
    x = plant(FREE | MOUNTS, ELASTIC)
    run(x, 3)
    assert np.all(steps(x, 5, first=3, names=(name,))[:, -1] == EXACT)


def test_inputs_that_return_give_the_same_bits():
    """The combined rows depend on the present inputs, not on those before."""
    values, rotor = MACHINES["mounts"]
    x, changed = (plant(values, rotor) for _ in range(2))
    for instance in (x, changed):
        run(instance, 40)
    state = x.state.copy()
    steps(changed, 5)
    for name in LARGEST:
        changed[name] = x[name]
    changed.state[:] = state
    np.testing.assert_array_equal(run(changed, 10, WATCHED), run(x, 10, WATCHED))
    assert scratch(changed).matrices.sizes[0].inputs > scratch(x).matrices.sizes[0].inputs


@pytest.mark.parametrize("machine", MACHINES)
def test_a_restored_state_under_changed_inputs_gives_the_same_bits(machine):
    values, rotor = MACHINES[machine]
    x = plant(values, rotor)
    steps(x, 50)
    fresh = Instance(x.model, x.constants)
    fresh.values[:] = x.values
    fresh.initialise()
    fresh.state[:] = x.state
    np.testing.assert_array_equal(steps(fresh, 20, first=50), steps(x, 20, first=50))


def test_changed_mounts_need_other_matrices():
    x = plant(FREE | MOUNTS, ELASTIC)
    run(x, 40)
    x["rb1.mount_stiffness_x"] = 2e7
    assert run(x, 1, ["solver.method"])[0] == NO_MATRICES
