"""Foreign FMUs: linearised by directional derivatives if these determine a step, else by differences."""

import sys
from pathlib import Path

import numpy as np
import pytest

from amb_analysis.linear.foreign import foreign_component
from amb_cosim.cosim.fmu.fmu_description import read_interface
from tests.support.c_fmus import ANY_STEP, INPUT, OUTPUT, PARAMETER, described
from tests.support.messages import assert_names, raises_naming

SOURCE = Path(__file__).parent / "support" / "spring.c"
H = 1e-4
M, D, K, CUBE = 2.0, 5.0, 8e4, 3e11  # of the spring
FORCE = 50.0  # N
LOCAL, STATE = 'causality="local"', ("Real", 'Real derivative="2"', 'Real derivative="3"')
DESCRIPTION = described(
    "Spring",
    [
        ("f", INPUT, 'Real start="0"'),
        *zip("xva", [LOCAL] * 3, STATE, strict=True),
        ("lag", PARAMETER, 'Real start="0"'),
        ("y", OUTPUT, "Real"),
    ],
    abilities=f'{ANY_STEP} providesDirectionalDerivative="true"',
    structure='<Derivatives><Unknown index="3"/><Unknown index="4"/></Derivatives>',
)
OSCILLATOR = described(
    "Oscillator",
    [
        ("u", INPUT, 'Real start="0"'),
        ("start", PARAMETER, 'Real start="0"'),
        ("eps", PARAMETER, 'Real start="0.3"'),
        ("y", OUTPUT, "Real"),
    ],
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")


@pytest.fixture(scope="module")
def folder(fmu_from_c, unpack):
    return unpack(fmu_from_c(SOURCE, DESCRIPTION))


def spring(folder, **start):
    interface = read_interface(folder, "spring")
    return foreign_component("spring", folder, interface, {"f": FORCE, **start}, (["f"], ["y"]), H)


def exact_poles():
    """z of m s^2 + d s + k + 3 c x^2 where the spring carries the force."""
    x = min(np.roots([CUBE, 0.0, K, -FORCE]), key=lambda root: abs(root.imag)).real
    return np.exp(H * np.roots([M, D, K + 3.0 * CUBE * x**2]))


def test_poles_are_those_of_the_derivatives_at_the_point(folder):
    part = spring(folder)
    assert_names(part.notes[0], "directional derivatives", "2 states")
    result = np.linalg.eigvals(part.law.A)
    np.testing.assert_allclose(np.sort_complex(result), np.sort_complex(exact_poles()), rtol=1e-12)
    assert part.law.D[0, 0] > 0.0


@pytest.mark.parametrize("lag", [2e-4, -1.0])
def test_differences_are_used_if_a_state_is_hidden_or_refused(folder, lag):
    """With a lag that is not listed the derivatives miss a state; with a negative one they are refused."""
    (note,) = (part := spring(folder, lag=lag)).notes
    assert_names(note, "spring", "responses to pulses")
    assert ("directional" in note) == (lag > 0.0)
    result = np.linalg.eigvals(part.law.A)
    for pole in exact_poles():
        assert np.abs(result / pole - 1.0).min() < 1e-4


@pytest.fixture(scope="module")
def oscillator(fmu_from_c, unpack):
    folder = unpack(fmu_from_c(SOURCE.with_name("oscillator.c"), OSCILLATOR))
    interface = read_interface(folder, "oscillator")
    return lambda **start: foreign_component("oscillator", folder, interface, start, (["u"], ["y"]), H)


def test_poles_at_rest_are_those_of_the_vibration_that_grows_into_a_limit_cycle(oscillator):
    """lambda^2 - eps w lambda + w^2 = 0."""
    part = oscillator(start=0.0, eps=0.3)
    expected = np.exp(H * np.roots([1.0, -0.3 * 400.0, 400.0**2]))
    np.testing.assert_allclose(np.sort_complex(np.linalg.eigvals(part.law.A)), np.sort_complex(expected), rtol=1e-5)
    assert "not linear" not in part.notes[0]


def test_a_limit_cycle_has_no_linear_model_or_a_note(oscillator):
    with raises_naming(ValueError, "oscillator", "0.0001 s", "limit cycle"):
        oscillator(start=2.0, eps=0.3)
    assert_names(oscillator(start=2.0, eps=0.01).notes[0], "not linear, or not at rest")
    assert "not linear" not in oscillator(start=2.0, eps=0.0).notes[0]  # moves, and is linear
