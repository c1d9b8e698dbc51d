"""Sense of the whirl that unbalance excites, and rotors that their bearings do not hold."""

import numpy as np
import pytest

from amb_cosim import studies
from amb_cosim.presentation.units import units
from rotor_analysis.parts import Bearing
from tests.support.analysis_cases import MASS, NOTHING, disc_between, spring, tensor
from tests.support.messages import assert_names

U = 1e-3  # kg m
AXES = 4e6, 1e7  # N/m, stiffness of each bearing along x and y


def split(damping=0.0, axes=AXES):
    """A Jeffcott rotor whose bearings have two stiffnesses, damped at the disc."""
    held = [Bearing(name, node, ((axes[0], 0.0), (0.0, axes[1]))) for name, node in (("left", 1), ("right", 3))]
    return disc_between(*held, Bearing("damper", 2, NOTHING, tensor(damping)))


def response(rotor, **options):
    return studies.unbalance_response(rotor, unbalance=U, node=2, up_to="1200 rad/s", **options)


def backward(damping, axes=AXES):
    """The area has the sign of Re(D_x conj D_y) = (k_x - m w^2)(k_y - m w^2) + c^2 w^2, D = k - m w^2 + i c w."""
    k_x, k_y = map(spring, axes)
    roots = np.roots([MASS**2, damping**2 - MASS * (k_x + k_y), k_x * k_y])
    return sorted(np.sqrt(roots)) if np.isrealobj(roots) else []


@pytest.mark.parametrize("damping", [0.0, 20.0, 60.0])
@pytest.mark.parametrize("axes", [AXES, AXES[::-1]])
def test_whirl_is_backward_between_two_split_critical_speeds(damping, axes):
    low, high = backward(damping, axes)
    result = response(split(damping, axes))
    for place in result.places.values():
        (ends,) = place.backward(result.speeds)
        assert ends == pytest.approx((low, high), rel=1e-3)
    with units("rad/s"):
        assert_names(str(result), "backward", f"{low:.4g}"[:4], f"{high:.4g}"[:4], "left, damper, right")


def test_damping_that_bridges_the_split_leaves_all_whirl_forward():
    """c = 90 N s/m > m (w_y - w_x) = 81 N s/m, which leaves the equation without real roots."""
    assert not backward(90.0)
    result = response(split(90.0))
    assert not any(place.backward(result.speeds) for place in result.places.values())
    assert "backward" not in str(result)


def test_equal_bearings_whirl_a_rotor_forward_at_all_speeds():
    assert "backward" not in str(response(split(0.0, (AXES[0], AXES[0]))))


def test_the_semi_axes_have_the_area_of_the_orbit():
    """pi a b = pi Im(conj(x) y) of x = Re[X exp(j theta)]: negative is against the spin."""
    low, high = backward(0.0)
    result = response(split())
    place = result.places["damper"]
    k_x, k_y = map(spring, AXES)
    X, Y = (U * result.speeds**2 / (k - MASS * result.speeds**2) for k in (k_x, k_y))
    between = (result.speeds > 1.01 * low) & (result.speeds < 0.99 * high)
    np.testing.assert_allclose((place.amplitude * place.minor)[between], (X * Y)[between], rtol=1e-5)
    assert (place.minor[between] < 0.0).all()


def on(*stiffness):
    return disc_between(*(Bearing(name, node, k) for name, node, k in zip("ab", (1, 3), stiffness, strict=True)))


@pytest.mark.parametrize(
    ("rotor", "count"),
    [
        (on(NOTHING, NOTHING), 4),
        (on(tensor(1e7), NOTHING), 2),
        (on(((1e7, 0.0), (0.0, 0.0)), ((1e7, 0.0), (0.0, 0.0))), 2),
        (on(tensor(1e7), ((1e7, 0.0), (0.0, 0.0))), 1),
        (on(tensor(1e7), tensor(1.0)), 0),
    ],
)
def test_rigid_body_motions_without_stiffness_are_counted(rotor, count):
    result = response(rotor)
    assert result.floating == count
    if count:
        assert_names(str(result), f"{count} of the 4 rigid-body motions", "floats", "no critical speed")
    else:
        assert "floats" not in str(result)


def test_a_floating_rotor_turns_about_its_centre_of_mass():
    """Without bearings the mass stays where it is, and the disc moves by u/m at any speed."""
    result = response(on(NOTHING, NOTHING))
    np.testing.assert_allclose(result.places["a"].amplitude, U / MASS, rtol=1e-6)
    assert not result.critical_speeds
