"""Studies mark results from coefficients beyond a table or of one whirl frequency, and growth beyond rounding."""

import pytest

from amb_analysis.studies.coefficient_limits import covered_speeds, is_extrapolated, limit_notes, limits_of
from amb_analysis.studies.figures import figure
from amb_cosim import studies
from rotor_analysis.parts import AtSpeed, Bearing, Body
from rotor_analysis.rotor import Rotor
from rotor_analysis.shaft import Shaft
from tests.support.messages import assert_names


def over_speed(*speeds: float) -> tuple[AtSpeed, ...]:
    one = ((2e7, 0.0), (0.0, 2e7))
    return tuple(AtSpeed(speed, one, ((2e3, 0.0), (0.0, 2e3))) for speed in speeds)


def rotor(*bearings: Bearing, seals: tuple[Bearing, ...] = (), disc_node: int = 3) -> Rotor:
    """A disc of 20 kg on a shaft; between bearings of 2e7 N/m it has critical speeds from 400 to 500 rad/s."""
    steel = {"youngs_modulus": 2e11, "density": 7800.0, "poissons_ratio": 0.3}
    shaft = Shaft(nodes=(0.0, 0.25, 0.5, 0.75, 1.0), diameter=(0.1,), **steel)
    disc = Body("disc", disc_node, mass=20.0, diametral_inertia=0.1, polar_inertia=0.2, unbalance=True)
    return Rotor("turbine", shaft, bodies=(disc,), bearings=bearings, seals=seals)


def tabled(*speeds: float) -> Rotor:
    return rotor(Bearing("left", 1, at_speed=over_speed(*speeds)), Bearing("right", 5, at_speed=over_speed(*speeds)))


SHORT, LONG = tabled(100.0, 300.0), tabled(0.0, 2000.0)
FROZEN = rotor(*(Bearing(name, node, 2e7, 2e3, whirl_frequency=200.0) for name, node in (("left", 1), ("right", 5))))


def marked_axes(result) -> int:
    """Number of axes of a figure with a hatched range of speeds."""
    return sum(any(patch.get_hatch() for patch in axes.patches) for axes in figure(result).axes)


@pytest.mark.parametrize("study", [studies.campbell, studies.unbalance_response])
def test_critical_speeds_beyond_a_table_are_marked(study):
    result = study(SHORT, up_to="700 rad/s")
    assert result.critical_speeds
    assert all(row.extrapolated == (row.speed > 300.0) for row in result.critical_speeds)
    assert_names(str(result), "left, right", "954.9 to 2865 rpm", "extrapolated")
    assert marked_axes(result) == 2


def test_nothing_within_a_table_is_marked():
    for study in (studies.campbell, studies.unbalance_response, studies.modes, studies.layout):
        options = {"up_to": "700 rad/s"} if study in (studies.campbell, studies.unbalance_response) else {}
        result = study(LONG, **options)
        assert "extrapolated" not in str(result)
        assert marked_axes(result) == 0


def test_modes_are_marked_only_at_speeds_beyond_a_table():
    result = studies.modes(SHORT, speeds="50 rad/s,200 rad/s,400 rad/s", count=2)
    outside = {Omega: at.extrapolated for Omega, at in result.frequencies.speeds.items()}
    assert outside == {50.0: True, 200.0: False, 400.0: True}
    assert str(result).count(", extrapolated") == 4
    assert "extrapolated" in figure(result).get_suptitle()


@pytest.mark.parametrize("study", [studies.campbell, studies.modes, studies.unbalance_response, studies.layout])
def test_coefficients_of_a_fixed_whirl_frequency_are_reported(study):
    result = study(FROZEN)
    assert_names(str(result), "left, right", "31.83 Hz")
    assert "whirl frequency" in figure(result).get_suptitle()
    assert "extrapolated" not in str(result)


def test_parts_with_the_same_table_share_a_note_and_others_do_not():
    parts = (*SHORT.bearings, Bearing("seal", 3, at_speed=over_speed(0.0, 500.0)), Bearing("plain", 2, 1e6))
    limits = limits_of(parts)
    assert [item.parts for item in limits] == [("left", "right"), ("seal",)]
    assert covered_speeds(limits) == (100.0, 300.0)
    assert [is_extrapolated(limits, Omega) for Omega in (99.0, 100.0, 300.0, 301.0)] == [True, False, False, True]
    assert len(limit_notes(limits, [0.0, 400.0])) == 1
    assert len(limit_notes(limits, [0.0, 600.0])) == 2


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.3, 1.0, 300.0, 3000.0])
def test_precession_of_a_free_rotor_is_not_unstable(speed):
    """Torque-free precession at speed I_p/I_t, 0.004 rad/s at 0.1 rad/s, neither grows nor decays."""
    assert "unstable" not in str(studies.modes(rotor(disc_node=2), speeds=f"{speed} rad/s"))


def test_slow_growth_of_a_rotor_in_soft_seals_is_unstable():
    """Cross coupling of 1 N/m between x and y, at both ends of a rotor in springs of 100 N/m."""
    seals = tuple(Bearing(name, node, ((100.0, 1.0), (-1.0, 100.0))) for name, node in (("a", 1), ("b", 5)))
    text = str(studies.modes(rotor(seals=seals, disc_node=2), speeds="0.1 rad/s", count=4))
    assert text.count("forward, unstable") == 2
