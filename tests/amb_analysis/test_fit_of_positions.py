"""Positions and lengths of a rotor file, fitted to responses of a rotor that is built otherwise."""

from dataclasses import replace

import numpy as np
import pytest

from amb_analysis.measured.records import Channel, FrequencyResponse, Measurement
from amb_analysis.studies.rotor_parameters import RotorParameters
from amb_cosim import studies
from rotor_analysis.assembly import assemble
from rotor_analysis.damping import free_modes
from tests.support.messages import raises_naming

FAN = """
name = "fan"
[shaft]
youngs_modulus = 2.1e11
density = 7800.0
poissons_ratio = 0.3
[[shaft.sections]]
length = 0.6
diameter = 0.03
[[shaft.sections]]
length = 0.1
diameter = 0.02
[[bodies]]
name = "wheel"
z = 0.4
mass = 4.2
radius = 0.1
width = 0.02
[[bearings]]
name = "left"
z = 0.05
stiffness = 2e7
damping = 300.0
[[bearings]]
name = "right"
z = 0.62
stiffness = 2e7
damping = 300.0
[damping]
modal = 0.004
"""
F = np.linspace(20.0, 600.0, 60)
PLACES = ("wheel.x", "0.1 m.x")


@pytest.fixture
def fan(tmp_path):
    path = tmp_path / "fan.toml"
    path.write_text(FAN)
    return path


def measured(fan, tmp_path, loop, old, new, noise=0.01):
    """Accelerations of the rotor with a line of its file changed."""
    built = tmp_path / "built.toml"
    assert FAN.count(old) == 1
    built.write_text(FAN.replace(old, new))
    curves = [FrequencyResponse(Channel(p, "m/s2"), Channel("wheel.f_x", "N"), F, np.ones(60, complex)) for p in PLACES]
    exact = studies.response(rotor=built, measured=Measurement(tuple(curves)), loop=loop).responses.values()
    rng = np.random.default_rng(1)
    factors = [1 + noise * (rng.standard_normal(60) + 1j * rng.standard_normal(60)) for _ in curves]
    values = [item.computed * factor for item, factor in zip(exact, factors, strict=True)]
    return Measurement(tuple(replace(c, values=v) for c, v in zip(curves, values, strict=True)))


@pytest.mark.parametrize(
    ("name", "bounds", "loop", "old", "new", "true"),
    [
        ("bodies.wheel.z", (0.3, 0.5), "free", "z = 0.4\n", "z = 0.412\n", 0.412),
        ("shaft.sections.1.length", (0.5, 0.65), "free", "length = 0.6\n", "length = 0.585\n", 0.585),
        ("shaft.sections.2.length", (0.05, 0.2), "free", "length = 0.1\n", "length = 0.13\n", 0.13),
        ("bearings.right.z", (0.55, 0.69), "linear", "z = 0.62\n", "z = 0.64\n", 0.64),
    ],
)
def test_positions_and_lengths_are_found(fan, tmp_path, name, bounds, loop, old, new, true):
    """The mesh did not move with the rotor: nodes were too close, or within a section."""
    result = studies.fit(fan, measured=measured(fan, tmp_path, loop, old, new), free={name: bounds}, loop=loop)
    fitted = result.fit.parameters[name]
    assert fitted.value == pytest.approx(true, abs=2e-3)
    assert fitted.lower < true < fitted.upper
    assert fitted.upper - fitted.lower < 5e-3


def test_an_offset_of_a_body_is_found(fan, tmp_path):
    """`wheel` is its centre of mass, where the force acts and the motion is measured."""
    data = measured(fan, tmp_path, "free", "width = 0.02\n", "width = 0.02\noffset = -0.045\n")
    fan.write_text(FAN.replace("width = 0.02\n", "width = 0.02\noffset = 0.0\n"))
    fitted = studies.fit(fan, measured=data, free={"bodies.wheel.offset": (-0.1, 0.1)}, loop="free")
    assert fitted.fit.parameters["bodies.wheel.offset"].value == pytest.approx(-0.045, abs=2e-4)


def test_the_mesh_moves_smoothly_with_a_position(fan):
    model = RotorParameters.load(fan, ["bodies.wheel.z"], [0.1])
    positions = np.linspace(0.36, 0.44, 17)
    rotors = [model.rotor_with([z]) for z in positions]
    assert len({len(rotor.shaft.nodes) for rotor in rotors}) == 1
    assert all(rotor.shaft.node_at(0.1) and rotor.shaft.node_at(z) for rotor, z in zip(rotors, positions, strict=True))
    models = [assemble(rotor) for rotor in rotors]
    lowest = np.array([free_modes(model.M[::2, ::2], model.K[::2, ::2])[0][2] for model in models])
    steps = np.diff(lowest)
    assert np.abs(np.diff(steps)).max() < 0.2 * np.abs(steps).max()


def test_a_position_that_meets_a_measured_one_is_refused(fan):
    model = RotorParameters.load(fan, ["bodies.wheel.z"], [0.1])
    with raises_naming(ValueError, "two positions", "same place", "bounds"):
        model.rotor_with([0.1])
