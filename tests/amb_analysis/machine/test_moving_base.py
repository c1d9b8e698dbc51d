"""A component that bearing forces move and that accelerates the base, such as a casing, in analyses over frequency.

The reference has absolute coordinates: rotor and casing are two bodies, and the bearing forces act on both.

    (D_r - L K R) X + L K R 1 y = F,    (m_c (s^2 + 2 zeta w s + w^2)) y + 1' L_b K (R X - 1 y) = 0
"""

import shutil
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.machine.channels import place_of
from amb_analysis.machine.feedback import bearing_forces
from amb_analysis.machine.frequency_response import Structure, frequency_response
from amb_analysis.machine.machine import machine_of
from amb_analysis.machine.response import passive, synchronous_response
from amb_analysis.steady_contact.forward_loop import forward_loop
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import as_scenario
from rotor_analysis.response import dynamic_stiffness
from tests.support.messages import raises_naming

EXAMPLE = Path(__file__).parents[3] / "examples" / "casing"
MASS, NATURAL, ZETA = 2000.0, 2.0 * np.pi * 80.0, 0.05  # of the casing, heavier than the rotor
SPEEDS = np.array([150.0, 480.0, 530.0, 900.0])  # rad/s, below, about and above the casing's frequency


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    from pythonfmu.builder import FmuBuilder

    folder = tmp_path_factory.mktemp("casing")
    shutil.copytree(EXAMPLE, folder, dirs_exist_ok=True)
    FmuBuilder.build_FMU(str(folder / "casing.py"), dest=str(folder))
    return machine_of(prepare_run(as_scenario(folder / "compressor_in_casing.toml"), {"casing.damping_ratio": ZETA}))


def two_bodies(machine, omega, Omega, loads):
    """Displacements of all nodes relative to the casing, due to forces (N) in the rotor's coordinates."""
    rotor = machine.free_rotor
    R, L = rotor.displacement_of(rotor.nodes), rotor.force_at(rotor.nodes)
    K = bearing_forces(machine, omega, Omega)
    D = dynamic_stiffness(passive(machine, Omega), Omega, np.array([omega]))[0]
    one = np.tile(np.eye(2), (len(rotor.nodes), 1))
    s = 1j * omega
    casing = MASS * (s**2 + 2.0 * ZETA * NATURAL * s + NATURAL**2) * np.eye(2)
    whole = np.block([[D - L @ K @ R, L @ K @ one], [one.T @ K @ R, casing - one.T @ K @ one]])
    motion = np.linalg.solve(whole, np.concatenate([loads, np.zeros((2, loads.shape[1]))]))
    return R @ motion[: len(D)] - one @ motion[len(D) :]


def test_the_unbalance_response_is_that_of_rotor_and_casing(machine):
    node = machine.rotor.node_of("impeller2")
    result = synchronous_response(machine, SPEEDS, [{node: 1e-4}])[:, 0].reshape(len(SPEEDS), -1)
    loads = machine.free_rotor.force_at([node]) @ np.array([[1e-4], [-1e-4j]])
    for Omega, motion in zip(SPEEDS, result, strict=True):
        exact = two_bodies(machine, Omega, Omega, Omega**2 * loads)[:, 0]
        assert np.linalg.norm(motion - exact) < 0.02 * np.linalg.norm(exact)  # the casing's force is a sample old


def test_the_closed_loop_response_is_that_of_rotor_and_casing(machine):
    inputs = [place_of("impeller2.f_x", "N", machine.rotor, is_input=True)]
    outputs = [place_of(name, "m", machine.rotor, is_input=False) for name in ("at_mb1.x", "at_seal.y")]
    structure = Structure(machine.rotor, "closed", machine.Omega, machine)
    result = frequency_response(structure, inputs, outputs, SPEEDS / (2.0 * np.pi))[:, :, 0]
    loads = machine.free_rotor.force_at([machine.rotor.node_of("impeller2")]) @ np.array([[1.0], [0.0]])
    rows = [2 * (node - 1) + axis for node, axis in (machine.signals[name] for name in ("at_mb1.x", "at_seal.y"))]
    for omega, motion in zip(SPEEDS, result, strict=True):
        exact = two_bodies(machine, omega, machine.Omega, loads)[rows, 0]
        assert np.linalg.norm(motion - exact) < 0.02 * np.linalg.norm(exact)


def test_the_casing_matters(machine):
    """Without the casing's motion the comparisons above would fail: it changes the response by more than a tenth."""
    node = machine.rotor.node_of("impeller2")
    loads = machine.free_rotor.force_at([node]) @ np.array([[1e-4], [-1e-4j]])
    Omega = SPEEDS[1]
    moving = two_bodies(machine, Omega, Omega, loads)
    rotor = machine.free_rotor
    R, L = rotor.displacement_of(rotor.nodes), rotor.force_at(rotor.nodes)
    D = dynamic_stiffness(passive(machine, Omega), Omega)
    fixed = R @ np.linalg.solve(D - L @ bearing_forces(machine, Omega, Omega) @ R, loads)
    assert np.linalg.norm(moving - fixed) > 0.1 * np.linalg.norm(fixed)


def test_steady_contact_names_the_component_that_it_cannot_include(machine):
    with raises_naming(ValueError, "casing.base.a_x", "rotor_contact.base.a_x", "amb_actuator.mb1.i_x"):
        forward_loop(machine.run_components, machine.Omega, ["td1"])


def test_the_component_that_moves_the_base_is_known(machine):
    assert machine.base_movers == ("casing",)
