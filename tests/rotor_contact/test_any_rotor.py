"""The plant of other rotors than the rig: any number of discs, bearings, sites and sensors, in any coordinates."""

from dataclasses import replace

import numpy as np
import pytest
from instances import initialised
from machines import SITES, held, machine
from rotor_cases import H, run

from amb_cosim.model_constants.plant_data import plant, plant_structure
from rotor_analysis.parts import Bearing, Site
from rotor_analysis.rigid_body import rigid_body
from rotor_analysis.rotor import ReductionOptions
from rotor_analysis.rotor_file import load_rotor


def test_variables_have_the_names_of_the_rotor_file():
    model, _ = plant(machine())
    names = set(model.interface.position)
    expected = {"impeller7.u", "impeller12.f_y", "mb3.k_xx", "mb3.phi", "seal2.clearance", "seal2.f_n", "probe3.y"}
    assert expected <= names
    assert not {"d1.u", "eb1.gap", "s1"} & names
    assert model.interface["seal1.journal_radius"].start == pytest.approx(0.045)  # of the shaft there
    assert model.interface["contact_state"].maximum == 7


def test_six_sites_in_contact_at_once_keep_the_energy_balance():
    """Pushed against all six, while it spins and slides: heat, strain and motion add up to the work."""
    pushed = {f"impeller{k}.f_x": 2.5e4 for k in range(1, 13)}
    condensed = machine(reduction=ReductionOptions("msdc"))
    x = initialised(*plant(condensed), held(3) | pushed | {"Omega": 150.0, "impeller5.u": 2e-3})
    for site in SITES:
        assert x[f"{site}.mode"] == 0.0
    closed = run(x, 100, [*(f"{site}.mode" for site in SITES), "energy.balance", "energy.work", "energy.friction"])
    assert np.max(np.sum(closed[:, :6] > 0.0, axis=1)) == 6
    assert closed[-1, 7] > 10.0
    assert np.max(np.abs(closed[:, 6])) < 5e-6 * np.max(np.abs(closed[:, 7]))


def test_contact_state_has_a_bit_for_each_bearing_in_contact():
    x = initialised(*plant(machine()), held(3) | {f"impeller{k}.f_y": 4e4 for k in range(8, 13)})
    state = run(x, 400, ["contact_state", "rb1.mode", "rb2.mode", "rb3.mode", "seal3.mode"])
    expected = 1.0 * (state[:, 1] > 0) + 2.0 * (state[:, 2] > 0) + 4.0 * (state[:, 3] > 0)
    np.testing.assert_array_equal(state[:, 0], expected)
    assert state[:, 0].max() >= 4.0


def static_deflection(rotor):
    """Return displacements of bearings and sensors under a steady force at one disc, after decay of the motion."""
    x = initialised(*plant(rotor), held(3, c_b=2e5) | {"impeller6.f_x": 100.0, "impeller6.f_y": -50.0})
    names = [f"{name}.{axis}" for name in ("mb1", "mb2", "mb3", "probe1", "probe3") for axis in "xy"]
    return run(x, 4000, names)[-1]


@pytest.mark.parametrize(
    ("reduction", "accuracy"),
    [(ReductionOptions(modes=4), 3e-3), (ReductionOptions(method="none"), 1e-6)],
    ids=["free_modes", "none"],
)
def test_static_deflection_does_not_depend_on_the_reduction(reduction, accuracy):
    """Condensed to the disc, a force there has its static deflection, in a few free modes nearly so."""
    condensed, other = machine(reduction=ReductionOptions("msdc")), machine(reduction=reduction)
    np.testing.assert_allclose(static_deflection(other), static_deflection(condensed), rtol=accuracy, atol=1e-12)
    assert plant_structure(other)[0].n_translations < len(plant_structure(other)[0].K)


def test_default_substep_resolves_the_fastest_mode():
    shortest = plant(machine(reduction=ReductionOptions(method="none")))[0].interface["solver.max_substep"].start
    assert shortest < 25e-6
    assert plant(load_rotor())[0].interface["solver.max_substep"].start == 250e-6


RIGID = ReductionOptions("free_modes", modes=0, accuracy=0.99)
IN_BEARINGS = {
    "bearings": (Bearing("mb1", 2), Bearing("mb2", 24)),
    "sites": (Site("rb1", 2, 0.2e-3, bearing="mb1"), Site("rb2", 24, 0.2e-3, bearing="mb2")),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("bearings", [2, 1])
def test_a_rotor_that_does_not_bend_moves_as_a_rigid_body(bearings):
    """x(z) = F t^2/2 (1/m + (z - c) (z_F - c)/I_t): translation and tilt about the centre of mass at c."""
    of_bearings = {name: parts[:bearings] for name, parts in IN_BEARINGS.items()}
    rotor = machine(reduction=RIGID, **of_bearings)
    rotor = replace(rotor, shaft=replace(rotor.shaft, mass_matrix="consistent"))
    body, z = rigid_body(rotor), np.array([rotor.shaft.nodes[part.node - 1] for part in rotor.sensors])
    structure, planes = plant_structure(rotor)
    assert len(structure.K) == 4
    assert planes.max_substep == 250e-6
    x = initialised(*plant(rotor), held(bearings, 0.0, 0.0) | {"mb1.f_x": 10.0, "Omega": 0.0})
    moved = run(x, 40, [f"{part.name}.x" for part in rotor.sensors])
    force_at = rotor.shaft.nodes[1] - body.centre
    expected = 0.5 * 10.0 * (40 * H) ** 2 * (1.0 / body.mass + (z - body.centre) * force_at / body.diametral_inertia)
    np.testing.assert_allclose(moved[-1], expected, rtol=1e-9)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("modes", [0, 1])
def test_a_rotor_that_hardly_bends_keeps_the_energy_balance_in_contact(modes):
    rotor = machine(reduction=replace(RIGID, modes=modes), **IN_BEARINGS)
    x = initialised(*plant(rotor), held(2) | {"impeller1.f_x": 4e3, "impeller9.f_y": -4e3, "Omega": 150.0})
    closed = run(x, 200, ["rb1.mode", "rb2.mode", "energy.balance", "energy.work"])
    assert np.all(np.any(closed[:, :2] > 0.0, axis=0))
    assert closed[-1, 3] > 1.0
    assert np.max(np.abs(closed[:, 2])) < 5e-6 * np.max(np.abs(closed[:, 3]))


def test_a_rotor_on_a_single_bearing_without_site_or_disc_runs():
    rotor = machine(bodies=(), sites=(), sensors=(), bearings=(Bearing("mb1", 12),))
    x = initialised(*plant(rotor), held(1) | {"mb1.f_x": 10.0, "Omega": 50.0})
    moved = run(x, 100, ["mb1.x", "contact_state"])
    assert moved[-1, 0] > 0.0
    assert not moved[:, 1].any()


def test_the_order_of_parts_in_the_file_does_not_change_the_motion():
    """With bearings that damp enough for the motion in contact to forget a difference of last bits."""
    rotor = machine(reduction=ReductionOptions("msdc"))
    turned = replace(rotor, bodies=rotor.bodies[::-1], sites=rotor.sites[::-1], bearings=rotor.bearings[::-1])
    values = held(3, c_b=2e5) | {"impeller3.u": 5e-3, "impeller9.f_x": 3e4, "Omega": 120.0, "seal3.mu": 0.2}
    names = ["mb1.x", "mb3.y", "probe1.x", "seal3.f_n", "seal3.f_t", "rb2.f_n", "rb3.f_n"]
    original, reordered = (run(initialised(*plant(r), values), 400, names) for r in (rotor, turned))
    assert np.all(np.max(np.abs(original), axis=0) > [*[1e-5] * 3, *[10.0] * 4])
    np.testing.assert_allclose(reordered, original, rtol=1e-6, atol=1e-12)
