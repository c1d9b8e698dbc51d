"""Ball bearings of retainers in machine files: refused where they cannot be built, loaded by a landing's force."""

import math
from pathlib import Path

import pytest

from amb_assessment.assessment.engine.assess import check_machine
from amb_assessment.assessment.format.machine_file import MachineFile, load_machine
from amb_assessment.assessment.format.retainer_bearings import (
    STANDING,
    STANDING_HEADS,
    TITLE,
    RetainerBearing,
    check_sites,
    load_tables,
)
from amb_assessment.assessment.page.description import description
from rotor_analysis.rigid_body import rigid_body
from tests.support.messages import assert_names, raises_naming

BLOWER = Path(__file__).parent / "blower" / "machine.toml"
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
    (table,) = load_tables([(bearing(), 900.0, 0.0)])
    (row,) = table.rows
    assert float(row[2]) == pytest.approx(4.37 * 900.0 / 9.0, rel=0.01)
    assert float(row[4]) == pytest.approx(2850.0 / 900.0, rel=0.01)
    assert load_tables([]) == ()


def test_pressure_at_the_static_rating_is_that_of_iso_76():
    """ISO 76 counts with Stribeck's 5, for bearings with clearance; without, a ball carries 4.37 of Z."""
    rating = bearing().bearing.static_rating
    assert bearing().pressure(rating) == pytest.approx(4200.0 * (4.37 / 5.0) ** (1.0 / 3.0), rel=0.005)


def test_a_bearing_without_force_has_no_load():
    (table,) = load_tables([(bearing(), 0.0, 0.0)])
    assert table.rows[0][1:] == ("0", "0", "0", "", "0")
    assert bearing().pressure(0.0) == 0.0


def test_balls_and_mount_of_a_fall_by_the_energy_of_the_fall():
    """33 N fall through 0.12 mm onto 10 MN/m: W (c + F/k) = F^2/(2 k), 317 N. Hertz: twice the balls' force is 2^1.5 of
    the displacement, so that the tangent stiffness grows as F^(1/3)."""
    W, c, k = 33.0, 0.12e-3, 1e7
    row, sentence = bearing().mounted(W, c, k)
    F = float(row[2])
    assert W * (c + F / k) == pytest.approx(F**2 / (2.0 * k), rel=1e-3)
    at_weight, at_fall = bearing().stiffness(W), bearing().stiffness(F)
    assert at_fall / at_weight == pytest.approx((F / W) ** (1.0 / 3.0), rel=1e-3)
    assert float(row[3]) == pytest.approx(1e-6 * at_fall, rel=1e-3)
    assert sentence == ""


def test_balls_that_are_as_soft_as_the_mount_are_stated_in_series():
    row, sentence = bearing().mounted(33.0, 0.12e-3, 1e8)
    balls = float(row[3])
    series = 1.0 / (1.0 / 100.0 + 1.0 / balls)
    assert balls < 5.0 * 100.0
    assert_names(sentence, "catch_n", f"{balls / 100.0:.2g} times", f"{series:.3g} MN/m", "housing_mass")


def test_the_inner_ring_of_a_6002_weighs_a_quarter_of_the_bearing():
    """Catalogues give 30 g for the whole bearing, of which rings are about 80 %; the inner ring is the smaller one."""
    assert bearing().inner_ring == pytest.approx(0.008, abs=0.003)


PAIR = {"at": "catch_lower", "balls": 13, "ball_diameter": "5.556 mm", "bore": "20 mm", "outside": "42 mm", "rows": 2}
PAIR |= {"contact_angle": "25 deg"}


def test_an_axial_force_of_a_landing_loads_the_balls_as_well():
    """1.6 kN along the shaft on 13 balls: 291 N each at 25 degrees, and 247 N at the 29.9 degrees under load."""
    item = RetainerBearing(**PAIR)
    tables = load_tables([(item, 0.0, 1600.0), (bearing(), 900.0, 0.0)])
    heads, rows = tables[0].heads, tables[0].rows
    first = dict(zip(heads, rows[0], strict=True))
    angle = math.radians(float(first["contact angle (deg)"]))
    assert float(first["ball load (N)"]) == pytest.approx(1600.0 / 13.0 / math.sin(angle), rel=2e-3)
    assert math.degrees(angle) == pytest.approx(29.9, abs=0.1)
    assert float(first["axial force (N)"]) == 1600.0
    assert item.pressure(0.0, 1600.0) > item.pressure(0.0, 800.0) > 0.0
    assert rows[1][:6] == load_tables([(bearing(), 900.0, 0.0)])[0].rows[0]
    # ISO 76: P_0 = 0.76 F_a for a pair of 25 degrees, of the angle without load
    assert item.equivalent_load(0.0, 100.0) == pytest.approx(0.76 * 100.0, rel=0.15)
    assert item.equivalent_load(70.0) == 70.0


def test_the_life_of_balls_on_which_a_rotor_stands_is_in_turns_and_hours():
    row = dict(zip(STANDING_HEADS, RetainerBearing(**PAIR).standing(500.0, 1000.0), strict=True))
    turns = 1e6 * float(row["life (10^6 turns)"])
    assert turns == pytest.approx(RetainerBearing(**PAIR).bearing.life(0.0, 500.0), rel=0.01)
    assert float(row["at the largest speed (h)"]) == pytest.approx(turns * 2.0 * math.pi / 1000.0 / 3600.0, rel=0.01)


def test_an_upright_pump_stands_on_the_retainer_of_its_lower_face():
    """Its weight of 108 N is on 13 balls of 25 degrees, 19.7 N each; they carry 19.2 N at 25.9 degrees."""
    pump = check_machine(load_machine("turbo_pump"))
    assert pump.stands_on == "catch_lower"
    assert pump.faces_at("catch_lower") == ("seat", "stop")
    (table,) = [block for block in description(pump, ()) if getattr(block, "title", None) == STANDING]
    cells = [next(iter(column.cells)) for column in table.columns]
    assert cells[0] == "catch_lower"
    axial, load, angle = map(float, cells[1:4])
    assert axial == pytest.approx(rigid_body(pump.rotor).mass * 9.81, rel=1e-3)
    assert load == pytest.approx(axial / 13.0 / math.sin(math.radians(angle)), rel=0.01)


def test_a_lying_machine_stands_on_nothing():
    blower = check_machine(load_machine(BLOWER))
    assert blower.stands_on == ""
    assert all(getattr(block, "title", None) != STANDING for block in description(blower, ()))


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"ball_diameter": "9 mm"}, ("> 0 m", "< 0.0085 m")),
        ({"balls": 30}, ("30", "0.0235 m")),
        ({"clearance": "-0.2 mm"}, ("clearance", "-0.0002 m")),
        ({"clearance": "3 N"}, ("clearance", "catch_n")),
        ({"static_rating": 0}, ("static_rating", "catch_n", "0 N", "> 0 N")),
        ({"preload": "10 N"}, ("preload", "10 N", "0 N")),
        ({"ball": "glass"}, ("steel",)),
        ({"cage": 1}, ("retainer_bearings.0.cage",)),
    ],
)
def test_a_bearing_that_cannot_be_built_is_refused(changes, facts):
    file = {"rotor": "rotor", "speed": {"minimum": 100.0, "maximum": 200.0}}
    with raises_naming(ValueError, *facts):
        MachineFile(**file, retainer_bearings=[SKF_6002 | changes])


@pytest.mark.parametrize("described", [("td_a",), ("td_a", "td_b")])
def test_a_retainer_carries_its_share_of_the_weight_whatever_the_file_describes(described):
    """By the rule of the lever between both retainers, 9.80665 m/s^2 times mass and arm of the centre of mass."""
    file = load_machine(BLOWER).model_copy(update={"retainer_bearings": tuple(bearing(at=at) for at in described)})
    subject = check_machine(file)
    body = rigid_body(subject.rotor)
    z = {site.name: subject.z[site.node - 1] for site in subject.rotor.sites}
    share = body.mass * (z["td_b"] - body.centre) / (z["td_b"] - z["td_a"])
    (table,) = (part for part in description(subject, ()) if str(getattr(part, "title", "")).startswith(TITLE))
    rows = list(zip(*(column.cells for column in table.columns), strict=True))
    stiffness, displacement = (float(rows[0][k]) for k in (4, 5))
    expected = bearing(at="td_a").data(9.80665 * share)
    assert (stiffness, displacement) == pytest.approx([float(expected[k]) for k in (4, 5)], rel=1e-3)
    assert bearing().data(0.0)[4] == "-"


def test_a_bearing_at_no_site_or_twice_at_one_is_refused():
    with raises_naming(ValueError, "catch_n", "catch_s"):
        check_sites([bearing()], ["catch_s"])
    with raises_naming(ValueError, "catch_n", "rows = 2"):
        check_sites([bearing(), bearing()], ["catch_n"])
    check_sites([bearing()], ["catch_n"])
