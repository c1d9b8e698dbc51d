"""Exact motion with free spin or retainers or changing gradients, compared with short Runge-Kutta substeps."""

import numpy as np
import pytest
from rotor_cases import BEARINGS, CLEARANCE, both, plant, run, scratch, workspace

from fmi_export.model import Instance
from rotor_analysis.rotor_file import load_rotor
from rotor_contact.matrices.matrix_inputs import combine
from rotor_contact.matrices.matrix_rows import build_slot
from rotor_contact.matrices.speed_grid import BLENDS, INTERPOLATION_ERROR, STRIDE, grid_speed, place_on_grid, slot_of
from rotor_contact.matrices.step_matrices import level_of, rows_of_x
from rotor_contact.shaft.structure import structure_of

SITES = ("rb1", "rb2", "eb1", "eb2")
FORCES = [f"{site}.{name}" for site in SITES for name in ("f_n", "f_t", "f_n_peak")]
ORBITS = [f"mb{k}.{axis}" for k in (1, 2) for axis in "xy"]
WATCHED = [*FORCES, *ORBITS, "speed", "energy.balance", "energy.dissipated", "energy.kinetic"]
ELASTIC = load_rotor("bath_rig")
FALL = (
    both("rb.mu", 0.12) | both("eb.mu", 0.12) | both("eb.enabled", 1) | {"gravity": 9.81, "Omega": 260.0, "d1.u": 5e-4}
)
MOUNT = both("rb.housing_mass", 3.0) | both("rb.mount_stiffness_x", 1e7) | both("rb.mount_damping_x", 1e4)
MOUNT |= both("rb.mount_stiffness_y", 2e7) | both("rb.mount_damping_y", 1e4)
FALLS = {
    "free spin": {"spin.free": 1},
    "mounts": MOUNT,
    "races and drive": both("rb.race_inertia", 2.5e-4)
    | both("rb.race_drag", 0.02)
    | {"spin.free": 1, "drive.gain": 2.0, "drive.torque_limit": 20.0},
}


@pytest.mark.parametrize("case", FALLS)
def test_fall_of_an_elastic_rotor_agrees_with_short_substeps(case):
    steps = 240
    values = FALL | FALLS[case]
    ours = run(plant(values, ELASTIC), steps, WATCHED)
    integrated = plant(values | {"solver.exact_motion": 0, "solver.max_substep": 7.5e-6}, ELASTIC)
    expected = run(integrated, steps, WATCHED)
    forces, orbits = slice(len(FORCES)), slice(len(FORCES), len(FORCES) + 4)
    peak = expected[:, forces].max()
    assert peak > 1000.0
    np.testing.assert_allclose(ours[:, forces], expected[:, forces], atol=1e-3 * peak)
    np.testing.assert_allclose(ours[:, orbits], expected[:, orbits], atol=1e-4 * CLEARANCE)
    np.testing.assert_allclose(ours[:, -4], expected[:, -4], rtol=1e-6)
    assert np.all(np.abs(ours[:, -3]) < 1e-6 * np.max(expected[:, -2:].sum(axis=1)) + 1e-4)


def test_interpolated_matrices_are_those_built_for_the_speed():
    """Random states of 44 coordinates after a step, with a disc whose gyroscopic moments turn its velocities."""
    x = plant(FALL | {"spin.free": 1, "Omega": 294.0}, ELASTIC)
    run(x, 60)
    matrices, w = scratch(x).matrices, workspace(x, x["speed"])
    index = float(np.floor(place_on_grid(matrices, x["speed"])))
    slot = slot_of(index)
    assert matrices.slots[slot].index == index
    assert 3 * STRIDE < 8 * (index % STRIDE) < 5 * STRIDE  # far from speeds that are built
    n, rows = int(matrices.sizes[0].n), rows_of_x(matrices)
    combine(matrices, slot, 0)
    build_slot(structure_of(x.constants), w.motion, w.sites, matrices, BLENDS, index, 1.0)
    combine(matrices, BLENDS, 0)
    interpolated, built = level_of(matrices, slot, 0), level_of(matrices, BLENDS, 0)
    assert not np.array_equal(interpolated.P[:rows], built.P[:rows])
    states = np.random.default_rng(5).normal(size=(50, rows))
    states[:, :n] /= grid_speed(matrices, index)
    for ours, theirs in ((interpolated.P[:rows, n:], built.P[:rows, n:]), (interpolated.S[:rows], built.S[:rows])):
        velocities, expected = states @ ours, states @ theirs
        np.testing.assert_allclose(velocities, expected, atol=INTERPOLATION_ERROR * np.abs(expected).max())
    heat, expected = (
        np.einsum("ki,ij,kj->k", states, np.tril(matrix[:rows, :rows]), states) for matrix in (interpolated.H, built.H)
    )
    np.testing.assert_allclose(heat, expected, atol=INTERPOLATION_ERROR * np.abs(expected).max())


def test_changing_gradients_agree_with_short_substeps():
    """Forces of the magnets change in every step, their gradients too; unstable, the bearings' springs hold."""
    steps, rng = 200, np.random.default_rng(3)
    values = rng.uniform(-1.0, 1.0, (steps, 2))
    paths = []
    for exact in (1, 0):
        x = plant(BEARINGS | {"Omega": 150.0, "d1.u": 1e-3, "solver.exact_motion": exact, "solver.max_substep": 1e-5})
        path = np.empty((steps, 5))
        for n, (force, gradient) in enumerate(values):
            x["mb1.f_x"], x["mb1.k_xx"], x["mb2.k_yy"] = 100.0 * force, 5e5 * gradient, -5e5 * gradient
            path[n] = run(x, 1, [*ORBITS, "energy.balance"], start=n * 250e-6)[0]
        paths.append(path)
    size = np.max(np.abs(paths[1][:, :4]))
    np.testing.assert_allclose(paths[0][:, :4], paths[1][:, :4], atol=1e-6 * size)
    assert np.max(np.abs(paths[0][:, 4])) < 1e-6 * x["energy.kinetic"] + 1e-9


HELD = {
    "shaft and bearings": BEARINGS,
    "shaft, no bearings": {},
    "free spin": BEARINGS | {"spin.free": 1.0},
    "mounts": BEARINGS | MOUNT,
    "speed ramp": BEARINGS | {"Omega_dot": 100.0},
}


@pytest.mark.parametrize("case", HELD)
def test_heat_and_work_of_held_forces_include_modes_faster_than_the_step(case):
    """Forces held over a step excite modes with several periods in it, without contact."""
    steps, names = 240, ["energy.damping", "energy.work", "energy.balance", "contact_state"]
    forces = np.random.default_rng(4).normal(scale=50.0, size=(steps, 4))
    values = {"Omega": 260.0, "d1.u": 5e-4, "mb1.k_xx": 3e5, "mb2.k_yy": -3e5, "solver.energy_limit": 1e9} | HELD[case]
    records = []
    for exact in (1.0, 0.0):
        x = plant(values | {"solver.exact_motion": exact, "solver.max_substep": 7.5e-6}, ELASTIC)
        record = np.empty((steps, 4))
        for n, force in enumerate(forces):
            x["mb1.f_x"], x["mb1.f_y"], x["mb2.f_x"], x["mb2.f_y"] = force
            record[n] = run(x, 1, names, start=n * 250e-6)[0]
        records.append(record)
    ours, integrated = records
    assert not np.any(integrated[:, 3])
    heat = integrated[-1, 0]
    assert heat > 1e-4
    np.testing.assert_allclose(ours[:, :2], integrated[:, :2], rtol=0.0, atol=1e-4 * heat)
    assert np.max(np.abs(ours[:, 2])) < 1e-5 * heat


def test_a_restored_state_continues_to_the_last_bit():
    values = FALL | FALLS["free spin"]
    x = plant(values, ELASTIC)
    run(x, 100)
    fresh = Instance(x.model, x.constants)
    fresh.values[:] = x.values
    fresh.initialise()
    fresh.state[:] = x.state
    np.testing.assert_array_equal(run(fresh, 20, WATCHED), run(x, 20, WATCHED))
