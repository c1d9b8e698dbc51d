"""Kinds of mode shapes: of a rigid body, of the rig, of a free shaft."""

import math
import tomllib

import numpy as np
import pytest
import tomli_w
from strange_machine import ROTOR as EXPANDER

from amb_analysis.studies.figures.modes import draw
from amb_cosim import studies
from rotor_analysis.assembly import assemble
from rotor_analysis.mode_kinds import kind_of
from rotor_analysis.parts import Bearing, Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.shaft import Shaft
from tests.support.analysis_cases import disc_between, tensor


def test_modes_of_the_rig_match_figs_3_2_and_3_3():
    """Conical at 61 rad/s, cylindrical at 106, first and second flexural at 179 and 429."""
    result = studies.modes(speeds=90.0, count=8)
    (shapes,) = result.shapes.values()
    assert [shape.kind for shape in shapes] == ["conical"] * 2 + ["cylindrical"] * 2 + ["flexural"] * 4
    assert [shape.crossings for shape in shapes] == [1, 1, 0, 0, 2, 2, 3, 3]
    (modes,) = result.frequencies.speeds.values()
    assert modes.frequencies[::2] == pytest.approx((61.0, 106.0, 179.0, 429.0), rel=0.02)
    assert "conical" in str(result)


@pytest.mark.parametrize(("offset", "kind", "crossings"), [(3.0, "cylindrical", 0), (-0.5, "conical", 1)])
def test_motion_of_a_rigid_body_is_classified_as_rigid(offset, kind, crossings):
    """x = (z + offset) exp(j phi), with the slope 1, and y a quarter of a turn later."""
    rotor = load_rotor()
    z = np.array(rotor.shaft.nodes)
    shape = np.zeros((len(z), 4), dtype=np.complex128)
    shape[:, 0], shape[:, 1], shape[:, 2], shape[:, 3] = z + offset, -1j * (z + offset), 1.0, -1j
    result = kind_of(assemble(rotor), z, shape.ravel() * np.exp(0.7j))
    assert result.rigid_share == pytest.approx(1.0)
    assert (result.name, result.crossings) == (kind, crossings)


def light_shaft():
    """A disc of 2 kg on an undamped shaft of 0.07 g with overhanging ends, in stiff bearings."""
    shaft = Shaft(tuple(np.linspace(0.0, 0.6, 13).tolist()), 0.012, 2e11, 1.0, 0.3)
    ends = (Bearing("a", 2, stiffness=1e9), Bearing("b", 12, stiffness=1e9))
    return Rotor("jeffcott", shaft, (Body("disc", 7, 2.0, 0.005, 0.01),), ends)


def test_an_undamped_rotor_on_a_light_shaft_grows_at_no_critical_speed():
    """Rounding gives its whirl damping ratios of 1e-8, of either sign."""
    diagram = studies.campbell(light_shaft(), up_to="3000 rpm")
    assert len(diagram.critical_speeds) == 2
    assert "unstable" not in str(diagram)


def test_a_disc_on_a_light_shaft_with_free_ends_moves_cylindrically():
    """The shaft bends, and its ends cross the axis at the bearings, but it has hardly any kinetic energy."""
    (shapes,) = studies.modes(light_shaft(), count=4).shapes.values()
    assert [shape.kind for shape in shapes] == ["cylindrical"] * 2 + ["conical"] * 2
    assert shapes[0].crossings == 2


SOFT = tuple(Bearing(name, node, tensor(1e5)) for name, node in (("left", 1), ("right", 3)))


@pytest.mark.parametrize("speeds", [[0.0, 4000.0], [4000.0, 0.0]])
def test_kinds_of_modes_are_those_of_each_speed(speeds):
    """Translation at 115 rad/s. Tilting has 800 rad/s at rest; at speed precession k L^2/(2 I_p Omega) = 89 rad/s and
    nutation I_p Omega/I_d = 7200 rad/s, below and above it.
    """
    result = studies.modes(disc_between(*SOFT), speeds=speeds, count=4)
    kinds = {speed: [shape.kind for shape in shapes] for speed, shapes in result.shapes.items()}
    assert kinds[0.0] == ["cylindrical", "cylindrical", "conical", "conical"]
    assert kinds[4000.0] == ["conical", "cylindrical", "cylindrical", "conical"]
    shapes_in_text = str(result).partition("Mode shapes")[2]
    assert shapes_in_text.count("38197.2") == 4  # rpm
    axes = [part for part in draw(result).axes if part.get_title()]
    assert [part.get_title().count("conical") for part in axes] == [
        shape.kind == "conical" for shapes in result.shapes.values() for shape in shapes
    ]


def test_bent_line_without_net_motion_is_flexural():
    rotor = load_rotor()
    z = np.array(rotor.shaft.nodes)
    shape = np.zeros((len(z), 4), dtype=np.complex128)
    k = 3.0 * np.pi / (z[-1] - z[0])
    shape[:, 0], shape[:, 2] = np.cos(k * z), -k * np.sin(k * z)
    result = kind_of(assemble(rotor), z, shape.ravel())
    assert result.name == "flexural"
    assert result.crossings == 3


def test_modes_without_a_resonance_come_last(tmp_path):
    """Bearings that damp the rigid modes of the expander beyond 1/sqrt(2) of critical damping."""
    data = tomllib.loads(EXPANDER.read_text(encoding="utf-8"))
    for bearing in data["bearings"]:
        bearing["damping"] = 1400.0
    file = tmp_path / "rotor.toml"
    file.write_text(tomli_w.dumps(data), encoding="utf-8")
    (at,) = studies.modes(load_rotor(file), speeds="3000 rpm", count=200).frequencies.speeds.values()
    flat = [f for f, ratio in zip(at.frequencies, at.damping_ratios, strict=True) if ratio > math.sqrt(0.5)]
    others = [f for f, ratio in zip(at.frequencies, at.damping_ratios, strict=True) if ratio <= math.sqrt(0.5)]
    assert list(at.frequencies) == sorted(others) + sorted(flat)
    assert min(flat) < min(others)


@pytest.mark.parametrize("speed", [0.0, 942.0])
def test_deflected_axes_of_twins_are_drawn_alike(speed):
    """A forward and a backward whirl of the same shape; both ends of its cone move by the same within 2 %."""
    result = studies.modes("compressor", speeds=speed, count=4)
    panels = [panel for panel in draw(result).axes if panel.get_title()]
    axes = [max((line.get_data_3d() for line in panel.lines), key=lambda data: len(data[0])) for panel in panels]
    for (_, _, first), (_, _, second) in (axes[:2], axes[2:]):
        np.testing.assert_allclose(first, second, atol=0.05)
        assert np.abs(first).max() > 0.98
    for (z, _, up), shape in zip(axes, result.shapes[speed], strict=True):
        np.testing.assert_allclose(np.interp(result.z, z, up), shape.y.real, atol=0.02)
