"""A shaft without mass is a spring between its bodies, as transfer-matrix programs have it."""

import numpy as np
import pytest
from analysis_cases import natural_frequencies

from amb_cosim.model_constants.plant_data import plant
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import Damping, free_modes
from rotor_analysis.harmonic import harmonic_model
from rotor_analysis.inertia import inertias, lacks_inertia
from rotor_analysis.modes import modes
from rotor_analysis.parts import Bearing, Body, Disc
from rotor_analysis.reduced_rotor import reduced_rotor, reduction_error, valid_to
from rotor_analysis.rotor import Mesh, Rotor
from rotor_analysis.rotor_file import rotor_from
from rotor_analysis.shaft import Shaft
from rotor_analysis.supported_rotor import supported_rotor
from tests.support.messages import raises_naming

E, D, L = 2e11, 0.04, 1.2
EI = E * np.pi * D**4 / 64.0
DENSITIES = [0.0, 1e-30, 1e-20]


def shaft(density, count=7):
    return Shaft(tuple(np.linspace(0.0, L, count).tolist()), D, E, density, 0.3, theory="rayleigh")


def points(density, masses, held=(), **options):
    """Bodies without rotary inertia at nodes, {node: kg}, and bearings of 1e12 N/m at the held nodes."""
    bodies = tuple(Body(f"m{node}", node, mass, 0.0, 0.0) for node, mass in masses.items())
    stiff = tuple(Bearing(f"b{node}", node, stiffness=1e12) for node in held)
    return Rotor("points", shaft(density), bodies, stiff, **options)


def influence(x, y):
    """Deflection (m) at x by 1 N at y of a beam on rigid supports at 0 and L."""
    a, b = min(x, y), L - max(x, y)
    return a * b * (L**2 - a**2 - b**2) / (6.0 * EI * L)


@pytest.mark.parametrize("density", DENSITIES)
def test_frequencies_of_point_masses_follow_from_the_beam_flexibility(density):
    """1/omega^2 are the eigenvalues of a_ij m_j."""
    masses = {3: 8.0, 5: 20.0}
    z = {node: L * (node - 1) / 6.0 for node in masses}
    rotor = points(density, masses, held=(1, 7))
    a = np.array([[influence(z[i], z[j]) * masses[j] for j in masses] for i in masses])
    expected = np.sort(1.0 / np.sqrt(np.linalg.eigvals(a)))
    assert natural_frequencies(rotor, 8) == pytest.approx(expected, rel=1e-5)
    frequencies = [mode.frequency for mode in modes(supported_rotor(rotor).model, 50.0, 4)]
    assert frequencies == pytest.approx(expected.repeat(2), rel=1e-5)
    assert np.max(np.abs(reduction_error(rotor).percent)) < 0.1
    assert valid_to(assemble(rotor), reduced_rotor(rotor).model) == 0.0, "no bending mode without bearings"


@pytest.mark.parametrize("density", [1e-9, 1e-12])
def test_reduction_of_a_light_shaft_keeps_its_frequencies(density):
    """Its fastest modes are lost in rounding, in the full or in the reduced model."""
    bearings = tuple(Bearing(name, node, stiffness=1e6) for name, node in (("a", 1), ("b", 5)))
    rotor = Rotor("light", shaft(density, 5), (Disc("wheel", 3, 10.0, 0.1, 0.02),), bearings, mesh=Mesh(modes=2))
    assert np.max(np.abs(reduction_error(rotor, 2).percent)) < 0.1


@pytest.mark.parametrize("density", DENSITIES)
def test_three_free_masses_have_one_bending_mode_with_its_ratio(density):
    """omega^2 = k (1/m + 1/(2 m)) of the middle against both ends, k = 48 E I / L^3."""
    rotor = points(density, {1: 5.0, 4: 5.0, 7: 5.0}, damping=Damping(modal=(0.03,)))
    omega = np.sqrt(1.5 * 48.0 * EI / L**3 / 5.0)
    model = assemble(rotor)
    assert free_modes(model.M[::2, ::2], model.K[::2, ::2])[0] == pytest.approx([omega], rel=1e-6)
    lowest = [mode for mode in modes(model, 0.0, 2) if mode.frequency > 1.0]
    assert [abs(mode.eigenvalue) for mode in lowest] == pytest.approx([omega, omega], rel=1e-6)
    assert [mode.damping_ratio for mode in lowest] == pytest.approx([0.03, 0.03], rel=1e-6)


@pytest.mark.parametrize("density", DENSITIES)
def test_response_on_a_massless_shaft_is_that_of_an_oscillator(density):
    """1 / (k - m omega^2) with k = 48 E I / L^3, below and above resonance."""
    rotor = points(density, {4: 10.0}, held=(1, 7))
    unit = np.eye(14)[:, [6]]
    omegas = np.array([10.0, 100.0, 3000.0])
    result = harmonic_model(rotor, (4,), 3000.0, rotor.bearings).response(omegas, 0.0, unit, unit.T, None)
    assert result[:, 0, 0] == pytest.approx(1.0 / (48.0 * EI / L**3 - 10.0 * omegas**2), rel=1e-5)


def test_error_of_the_plant_names_the_massless_nodes():
    rotor = Rotor("light", shaft(0.0, 3), (Disc("wheel", 2, 10.0, 0.1, 0.02),), (Bearing("a", 1), Bearing("b", 3)))
    with raises_naming(ValueError, "shaft.density = 0 kg/m3", "[1, 3]", "> 0 kg/m3"):
        plant(rotor)


def test_rotor_without_any_mass_is_refused():
    table = {"nodes": [0.0, 1.0], "diameter": 0.1, "youngs_modulus": 2e11, "density": 0.0, "poissons_ratio": 0.3}
    with raises_naming(ValueError, "mass", "0 kg", "> 0 kg"):
        rotor_from({"name": "nothing", "shaft": table}, "rotor file")


@pytest.mark.filterwarnings("error")
def test_a_motion_without_stiffness_has_inertia():
    """A rigid rotor, in the coordinates of two places, has mass and no stiffness; a massless place has no inertia."""
    M, none = np.array([[2.0, 0.5], [0.5, 2.0]]), np.zeros((2, 2))
    assert not lacks_inertia(M, none)
    assert inertias(M, none) == 2
    assert [len(part) for part in free_modes(M, none)] == [0, 2]
    spring = 1e6 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    assert lacks_inertia(np.diag([2.0, 0.0]), spring)
    assert inertias(np.diag([2.0, 0.0]), spring) == 1
