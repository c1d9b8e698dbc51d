"""The plant's model of any rotor: reduced by the method and to the accuracy of its file, with the required planes."""

from dataclasses import replace

import numpy as np
import pytest
from analysis_cases import STEEL, natural_frequencies

from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.damping import free_modes
from rotor_analysis.masters import needed_masters
from rotor_analysis.mesh_accuracy import refine_to_accuracy
from rotor_analysis.modes import damped_frequencies
from rotor_analysis.parts import Bearing, Disc, Sensor, Site
from rotor_analysis.reduced_rotor import elastic_shapes, reduced_rotor, reduction_error, valid_to, with_modes
from rotor_analysis.reduction import msdc, reduce_by
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.sections import ShaftSection
from rotor_analysis.shaft import SectionedShaft
from tests.support.messages import raises_naming

RIG = load_rotor()


def compressor(stiffness=2e7, **options):
    """Twelve discs between the outer two of three bearings, six sites, two sensor planes."""
    discs = tuple(
        Disc(f"impeller{k}", z=0.3 + 0.12 * k, mass=8.0, radius=0.15, width=0.03, unbalance=k % 2 == 0)
        for k in range(12)
    )
    bearings = tuple(Bearing(f"mb{k}", z=z, stiffness=stiffness) for k, z in enumerate((0.1, 1.0, 1.9)))
    sites = tuple(Site(f"seal{k}", z=z) for k, z in enumerate((0.1, 0.25, 0.8, 1.0, 1.75, 1.9)))
    sensors = (Sensor("left", z=0.15), Sensor("right", z=1.85))
    shaft = SectionedShaft((ShaftSection(0.2, 0.05), ShaftSection(1.6, 0.08), ShaftSection(0.2, 0.05)), **STEEL)
    rotor = Rotor("compressor", shaft, discs, bearings, sites, sensors)
    return replace(refine_to_accuracy(rotor, 6, 1e-3), reduction=ReductionOptions(**options))


COMPRESSOR = compressor()


def test_rig_keeps_the_planes_that_its_file_names():
    reduced, condensed = reduced_rotor(RIG), msdc(assemble(RIG), RIG.masters)
    assert list(reduced.model.translations) == [1, 3, 4, 10, 11, 13]
    for name in ("M", "C", "G", "K"):
        np.testing.assert_array_equal(getattr(reduced.model, name), getattr(condensed.model, name))
    assert np.all(np.abs(reduction_error(RIG, 4).percent) < 0.12)


@pytest.mark.parametrize("accuracy", [0.05, 0.01])
@pytest.mark.parametrize("stiffness", [0.0, 2e7])
def test_first_modes_are_as_accurate_as_stated(stiffness, accuracy):
    rotor = compressor(stiffness, method="msdc", accuracy=accuracy)
    model = reduced_rotor(rotor).model
    assert set(needed_masters(rotor)) <= set(model.translations)
    assert np.max(np.abs(reduction_error(rotor).percent)) <= 100.0 * accuracy
    assert model.size < assemble(rotor).size


def test_planes_are_added_only_where_they_are_needed():
    bare = replace(
        COMPRESSOR, bodies=tuple(replace(b, unbalance=False) for b in COMPRESSOR.bodies), sites=(), sensors=()
    )
    sizes = []
    for accuracy in (0.3, 0.05, 0.01):
        rotor = replace(bare, reduction=ReductionOptions("msdc", accuracy=accuracy))
        sizes.append(len(reduced_rotor(rotor).model.translations))
        assert np.max(np.abs(reduction_error(rotor).percent)) <= 100.0 * accuracy
    assert 3 <= sizes[0] < sizes[1] < sizes[2] < len(rotor.shaft.nodes)


@pytest.mark.parametrize("method", ["msdc", "none"])
def test_translations_of_the_masters_come_first_in_pairs(method):
    reduction = reduced_rotor(replace(COMPRESSOR, reduction=ReductionOptions(method, accuracy=0.01)))
    full, model = assemble(COMPRESSOR), reduction.model
    for node, (x, y) in model.translations.items():
        assert y == x + 1
        np.testing.assert_array_equal(reduction.right[full.rows((node,))], np.eye(model.size)[[x, y]])
    if method != "none":
        assert list(model.translations.values()) == [(2 * k, 2 * k + 1) for k in range(len(model.translations))]
    assert set(needed_masters(COMPRESSOR)) <= set(model.translations)


def test_unreduced_rotor_is_the_full_model():
    rotor = replace(COMPRESSOR, reduction=ReductionOptions("none"))
    model = reduced_rotor(rotor).model
    np.testing.assert_array_equal(model.K, assemble(rotor).K)
    np.testing.assert_array_equal(reduction_error(rotor).percent, 0.0)


def test_frequencies_converge_from_above_with_more_free_modes():
    """Rayleigh-Ritz: bounds from above, lower with every added mode, and exact with all of them."""
    exact = natural_frequencies(RIG, 6)
    previous = np.inf
    for modes in (0, 1, 2, 4, 8, 24):
        rotor = replace(RIG, reduction=ReductionOptions(modes=modes, accuracy=1e-12))
        error = reduction_error(rotor)
        assert np.all(error.percent > -1e-6)
        assert np.max(error.percent) <= previous * (1.0 + 1e-6) + 1e-7
        previous = np.max(error.percent)
    assert reduced_rotor(rotor).model.size == assemble(RIG).size
    np.testing.assert_allclose(error.percent, 0.0, atol=1e-6)
    np.testing.assert_allclose(error.frequencies, exact)


@pytest.mark.parametrize("modes", [0, 3])
def test_elastic_shapes_of_a_plant_are_modes_and_residual_shapes(modes):
    """Thesis's rig has four places, with a residual shape each where the accuracy is high enough."""
    places, nodes = 4, len(RIG.shaft.nodes)
    rotor = with_modes(RIG, modes)
    exact = replace(rotor, reduction=replace(rotor.reduction, accuracy=1e-9))
    assert elastic_shapes(exact) == (modes + places, 2 * nodes - 2)


def test_a_part_that_a_rotor_lacks_is_refused_by_name():
    assert RIG.node_of(RIG.bearings[0].name) == RIG.bearings[0].node
    with raises_naming(ValueError, RIG.name, "wheel"):
        RIG.node_of("wheel")


def test_reduction_is_valid_up_to_its_last_accurate_free_mode():
    """Thesis's six planes have the rotor's first two elastic modes; the third is 8 % too fast."""
    full, elastic = assemble(RIG), 2
    reduced = msdc(full, RIG.masters).model
    exact, result = (free_modes(model.M[::2, ::2], model.K[::2, ::2])[0] for model in (full, reduced))
    assert valid_to(full, reduced) == exact[elastic - 1]
    assert np.all(result[:elastic] / exact[:elastic] - 1.0 <= 0.01)
    assert result[elastic] / exact[elastic] - 1.0 > 0.01


def test_unreduced_rotor_is_valid_up_to_its_fastest_mode():
    full = assemble(RIG)
    assert valid_to(full, full) == free_modes(full.M[::2, ::2], full.K[::2, ::2])[0][-1]
    assert valid_to(full, msdc(full, (4, 11)).model) == 0.0


@pytest.mark.parametrize("Omega", [0.0, 300.0, -300.0])
def test_spinning_reduced_rotor_whirls_as_the_full_model(Omega):
    held = RIG.on_equal_bearings(1e6, 500.0)
    full = on_bearings(assemble(held), held)
    exact, errors = damped_frequencies(full, Omega, 10), []
    for modes in (0, 12):
        free = reduced_rotor(replace(held, reduction=ReductionOptions(modes=modes)))
        model = reduce_by(full, free.model.translations, free.right, free.left).model
        errors.append(np.max(np.abs(damped_frequencies(model, Omega, 10) / exact - 1.0)))
    assert errors[1] < 2e-4 < 1e-2 < errors[0]


def test_rotor_without_parts_keeps_the_ends_of_its_shaft():
    rotor = Rotor("shaft", SectionedShaft((ShaftSection(0.5, 0.05), ShaftSection(0.5, 0.06)), **STEEL))
    assert needed_masters(rotor) == (1, 3)


@pytest.mark.parametrize(
    ("options", "facts"),
    [
        ({"method": "none", "masters": (1, 2)}, ("masters", "msdc", "'none'")),
        ({"method": "msdc", "modes": 3}, ("modes", "free_modes", "'msdc'")),
        ({"masters": (1, 2), "speed": 300.0}, ("speed", "free_modes", "'msdc'")),
        ({"method": "msdc", "band": 1000.0}, ("band", "free_modes", "'msdc'")),
        ({"method": "free_modes", "modes": 3, "band": 1000.0}, ("modes", "band")),
        ({"method": "guyan"}, ("method", "'guyan'", "'free_modes'", "'msdc'", "'none'")),
    ],
)
def test_option_of_another_method_is_refused(options, facts):
    with raises_naming(ValueError, *facts):
        ReductionOptions(**options)


def test_unattainable_accuracy_of_condensation_is_refused():
    with raises_naming(ValueError, "reduction.accuracy", "1e-09"):
        reduced_rotor(compressor(method="msdc", accuracy=1e-9))
