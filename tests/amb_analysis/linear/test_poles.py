"""Poles of a levitated machine over its speed."""

from dataclasses import replace

import numpy as np
import pytest

from amb_analysis.linear.loop import LoopPoles
from amb_analysis.studies.closed_loop_poles import _crossings, _over_speed
from amb_analysis.studies.loop_vibrations import Vibrations, begun_later, followed, least_damped, vibrations_over
from amb_cosim import studies
from amb_cosim.results.loop_stability import LoopStability
from rotor_analysis.damping import Damping
from rotor_analysis.rotor_file import load_rotor
from tests.support.messages import assert_names

COMPRESSOR = "compressor_levitated"
STABLE = LoopStability(radius=0.99, growth_rate=-100.0, frequency=10.0)


@pytest.fixture(scope="module")
def diagram():
    return studies.poles(COMPRESSOR)


def test_forward_whirl_stiffens_with_speed_and_backward_whirl_softens(diagram):
    seen = set()
    for pole in diagram.poles:
        if pole.whirl[0] in ("forward", "backward") and pole.frequencies[0] > 2.0 * np.pi * 100.0:
            assert set(pole.whirl) == {pole.whirl[0]}
            assert (pole.frequencies[-1] > pole.frequencies[0]) == (pole.whirl[0] == "forward")
            seen.add(pole.whirl[0])
    assert seen == {"forward", "backward"}


def test_logarithmic_decrement_and_damping_ratio_agree(diagram):
    assert len(diagram.poles) == 8
    assert diagram.unstable == ()
    for pole in diagram.poles:
        assert np.isfinite(pole.frequencies).all()
        zeta = pole.damping_ratios
        np.testing.assert_allclose(pole.decrements, 2.0 * np.pi * zeta / np.sqrt(1.0 - zeta**2), rtol=1e-12)


@pytest.mark.usefixtures("few_speeds")
def test_less_damping_in_the_control_damps_the_rotor_less(diagram):
    softer = studies.poles(COMPRESSOR, set={"rolac_controller.*.c_b_?": 2e4}, up_to=300.0, count=2)
    assert max(pole.decrements[0] for pole in softer.poles) < 0.7 * diagram.poles[0].decrements[0]


@pytest.mark.usefixtures("few_speeds")
def test_loss_factor_becomes_viscous_damping_with_a_warning(diagram):
    """Half of the loss factor is the damping ratio of an elastic mode at rest that the magnets hardly hold."""
    rotor = load_rotor("compressor")
    lossy, lossless = (
        studies.poles(COMPRESSOR, rotor=replace(rotor, damping=Damping(loss_factor=eta)), up_to=3.0, flavour="python")
        for eta in (0.02, 0.0)
    )
    assert_names(lossy, "loss_factor = 0.02", "viscous")
    assert lossless.warnings == diagram.warnings == ()
    added = [b.damping_ratios[0] - a.damping_ratios[0] for a, b in zip(lossless.poles, lossy.poles, strict=True)]
    assert max(added) == pytest.approx(0.01, rel=0.1)


@pytest.mark.usefixtures("few_speeds")
def test_late_currents_make_an_elastic_mode_unstable():
    """A sample more of delay, and the mode at 1.2 or at 1.7 kHz has no phase left."""
    late = {"rolac_controller.chain.preset": "custom", "rolac_controller.chain.delay": True}
    result = studies.poles(COMPRESSOR, set=late, up_to=300.0, count=30)
    assert len(result.unstable) == len(result.speeds)
    assert_names(result, "2.865 to 2865 rpm")
    growing = [pole for pole in result.poles if pole.decrements[0] < 0.0]
    assert growing
    assert all(pole.frequencies[0] > 2.0 * np.pi * 1000.0 for pole in growing)


def test_crossing_poles_are_followed_by_slope_and_sense_of_whirl():
    """Two poles cross at the fifth speed, the forward one from below; lists are ordered by frequency."""
    speeds = np.linspace(0.0, 1.0, 9)
    result = []
    for speed in speeds:
        s, senses = np.array([9.0 + 2.0 * speed, 11.0 - 2.0 * speed]) * 1j - 0.1, np.array([1.0, -1.0])
        order = np.argsort(s.imag, kind="stable")
        result.append(Vibrations(s[order], senses[order], STABLE))
    for track, sense in zip(followed(result, 2), (1.0, -1.0), strict=True):
        assert all(at.senses[k] == sense for at, k in zip(result, track, strict=True))


def test_a_pole_that_disappears_ends_its_track():
    both = Vibrations(np.array([10j - 0.1, 30j - 0.1]), np.array([1.0, 1.0]), STABLE)
    single = Vibrations(both.poles[:1], both.senses[:1], STABLE)
    assert followed([both, both, single, both], 2) == [[0, 0, 0, 0], [1, 1, None, None]]


@pytest.fixture(scope="module")
def tilting():
    """Return speeds (rad/s), vibrations of a damped gyroscopic rotor that creeps at rest, and parameters.

    I_d a'' + (c - i Omega I_p) a' + k a = 0, c^2 > 4 I_d k: none at rest, k/(Omega I_p) backward at speed.
    """
    I_d, I_p, c, k = 1e-3, 8e-4, 4.0, 100.0
    speeds, result = np.linspace(10.0, 1e5, 41), []
    for speed in speeds:
        roots = np.roots([I_d, c - 1j * speed * I_p, k])
        s = np.where(roots.imag < 0.0, roots.conj(), roots)
        order = [n for n in np.argsort(s.imag) if -s[n].real < 0.995 * abs(s[n])]
        result.append(Vibrations(s[order], np.sign(roots.imag)[order], STABLE))
    assert len(result[0].poles) == 0
    return speeds, result, k / I_p


def test_precession_that_creeps_at_rest_is_followed_from_where_it_begins(tilting):
    _, result, rate = tilting
    tracks = begun_later(result, followed(result, 8))
    (precession,) = [track for track in tracks if result[-1].senses[track[-1]] < 0.0]
    assert result[-1].poles[precession[-1]].imag == pytest.approx(rate / 1e5, rel=0.01)
    begun = [at.senses[n] for at, n in zip(result, precession, strict=True) if n is not None]
    assert begun == [-1.0] * sum(-1.0 in at.senses for at in result)


def test_a_vibration_that_begins_below_the_speed_is_not_critical_there(tilting):
    """Precession of k/(Omega I_p) begins where it is slower than the rotor rotates, and remains so."""
    speeds, result, _ = tilting
    tracks = begun_later(result, followed(result, 8))
    over_speed = [_over_speed(result, track) for track in tracks]
    assert all(np.isnan(pole.frequencies[0]) and np.isfinite(pole.frequencies[-1]) for pole in over_speed)
    assert all(np.isnan(pole.frequencies).sum() == np.isnan(pole.decrements).sum() for pole in over_speed)
    (precession,) = [pole for pole in over_speed if pole.whirl[-1] == "backward"]
    exists = np.isfinite(precession.frequencies)
    assert (precession.frequencies[exists] < speeds[exists]).all()
    assert not list(_crossings(speeds, [precession]))


class DampedLeastBetweenSpeeds:
    """A loop with a vibration of 1000 rad/s: zeta = 0.05 - 0.03/(1 + ((Omega - 133)/w)^2)."""

    def __init__(self, width):
        self.width = width

    def poles(self, Omega):
        zeta = 0.05 - 0.03 / (1.0 + ((Omega - 133.0) / self.width) ** 2)
        s = 1000.0 * complex(-zeta, np.sqrt(1.0 - zeta**2))
        pair, shapes = np.array([s, s.conjugate()]), np.array([[1.0, 1.0], [-1.0j, 1.0j]])
        stability = LoopStability(np.exp(1e-4 * s.real), s.real, s.imag, speed=Omega)
        return LoopPoles(np.exp(1e-4 * pair), pair, shapes, stability)


@pytest.mark.parametrize("width", [30.0, 60.0, 120.0])
def test_least_damping_ratio_is_that_between_the_speeds_of_the_diagram(width):
    """0.02 at 133 rad/s, of a diagram whose speeds are 50 rad/s apart."""
    speeds = np.linspace(0.0, 400.0, 9)
    closer, at_speeds = vibrations_over(DampedLeastBetweenSpeeds(width), speeds)
    least = least_damped(closer, at_speeds)
    assert least.damping_ratio == pytest.approx(0.02, rel=1e-3)
    assert least.speed == pytest.approx(133.0, abs=0.05 * width)
    assert least.frequency == pytest.approx(1000.0 * np.sqrt(1.0 - 0.02**2), rel=1e-6)
    assert max(of.stability.growth_rate for of in at_speeds) == pytest.approx(-20.0, rel=1e-3)
    assert set(speeds) <= set(closer)


def test_least_damping_ratio_of_a_machine_is_that_of_its_table(diagram):
    """No followed vibration has less; the printed line names its ratio, speed and frequency."""
    least = diagram.least_damped
    assert least.damping_ratio <= min(float(np.nanmin(pole.damping_ratios)) for pole in diagram.poles)
    assert_names(str(diagram), "least damped", f"{least.damping_ratio:.4g}")
