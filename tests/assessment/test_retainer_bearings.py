"""Ball bearings of retainers in machine files: refused where they cannot be built, loaded by a landing's force."""

from __future__ import annotations

import pytest

from amb_cosim.assessment.machine_file import MachineFile
from amb_cosim.assessment.retainer_bearings import RetainerBearing, check_sites, load_tables

SKF_6002 = {
    "at": "catch_n",
    "balls": 9,
    "ball_diameter": "4.762 mm",
    "bore": "15 mm",
    "outside": "32 mm",
    "static_rating": "2.85 kN",
}


def bearing(**changes):
    return RetainerBearing(**(SKF_6002 | changes))


def test_a_landing_loads_a_ball_by_stribecks_share():
    (table,) = load_tables([(bearing(), 900.0)])
    (row,) = table.rows
    assert float(row[2]) == pytest.approx(4.37 * 900.0 / 9.0, rel=0.01)
    assert float(row[4]) == pytest.approx(2850.0 / 900.0, rel=0.01)
    assert load_tables([]) == ()


def test_pressure_at_the_static_rating_is_that_of_iso_76():
    """ISO 76 counts with Stribeck's 5, for bearings with clearance; without, a ball carries 4.37 of Z."""
    rating = bearing().bearing.static_rating
    assert bearing().pressure(rating) == pytest.approx(4200.0 * (4.37 / 5.0) ** (1.0 / 3.0), rel=0.005)


def test_a_bearing_without_force_has_no_load():
    (table,) = load_tables([(bearing(), 0.0)])
    assert table.rows[0][1:] == ("0", "0", "0", "", "0")
    assert bearing().pressure(0.0) == 0.0


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"ball_diameter": "9 mm"}, "must be > 0 m and < 0.0085 m, half the difference of outside and bore"),
        ({"balls": 30}, "30 balls do not fit on 0.0235 m"),
        ({"clearance": "-0.2 mm"}, "clearance = -0.0002 m is not allowed"),
        ({"clearance": "3 N"}, "clearance of the bearing at catch_n"),
        ({"static_rating": 0}, "static_rating of the bearing at catch_n = 0 N must be > 0 N"),
        ({"preload": "10 N"}, "preload = 10 N is not allowed; it must be 0 N without a contact angle"),
        ({"ball": "glass"}, "steel"),
        ({"cage": 1}, "cage"),
    ],
)
def test_a_bearing_that_cannot_be_built_is_refused_in_a_sentence(changes, sentence):
    file = {"rotor": "rotor", "speed": {"minimum": 100.0, "maximum": 200.0}}
    with pytest.raises(ValueError, match=sentence):
        MachineFile(**file, retainer_bearings=[SKF_6002 | changes])


def test_a_bearing_at_no_site_or_twice_at_one_is_refused():
    with pytest.raises(ValueError, match="no contact site 'catch_n' for a bearing; did you mean catch_s"):
        check_sites([bearing()], ["catch_s"])
    with pytest.raises(ValueError, match="two retainer_bearings are at catch_n; a pair is one bearing with rows = 2"):
        check_sites([bearing(), bearing()], ["catch_n"])
    check_sites([bearing()], ["catch_n"])
