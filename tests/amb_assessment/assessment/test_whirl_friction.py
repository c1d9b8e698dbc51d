"""Whether landings whirl backward is judged by the friction that drives a fall over the top, not by chance."""

import math
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from fall_over_top import RIGID, friction_over_top
from machine_variants import halved, in_other_units, mirrored, read, toml_text
from slow import slow_but_first

from amb_assessment.assessment.analyses import landing
from amb_assessment.assessment.engine.assess import check_machine
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import Quantity
from amb_assessment.assessment.physics import whirl_friction as whirl_module
from amb_assessment.assessment.physics.lying_rotor import lying_on
from amb_assessment.assessment.physics.runs import worst_inputs
from amb_assessment.assessment.physics.whirl_friction import chance, whirl_friction
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.static_load import carried_at
from tests.support.messages import assert_names

BLOWER = Path(__file__).parent / "blower"
FRICTION = 0.15
ON_RETAINERS = {"friction": FRICTION, "on_face": 0.0}


def files_of(machine, folder):
    """Write a machine, with its rotor in a file beside it."""
    if machine == "blower":
        shutil.copytree(BLOWER, folder, dirs_exist_ok=True)
        return
    data = load_machine(machine).model_dump(mode="json", exclude_unset=True, exclude_none=True)
    (folder / "rotor.toml").write_text(rotor_path(machine).read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "machine.toml").write_text(toml_text(data | {"rotor": "rotor.toml"}), encoding="utf-8")


def rewritten(change, folder):
    (folder / "rotor.toml").write_text(toml_text(change(read(folder / "rotor.toml"))), encoding="utf-8")


def in_units(folder):
    for path in folder.glob("*.toml"):
        path.write_text(in_other_units(path.read_text(encoding="utf-8")), encoding="utf-8")


SAME = {"mirrored": partial(rewritten, mirrored), "finer mesh": partial(rewritten, halved), "other units": in_units}


def least(folder_or_file, **parameters):
    """Return the friction of a machine, with other parameters of its plant."""
    file = folder_or_file if not isinstance(folder_or_file, Path) else load_machine(folder_or_file / "machine.toml")
    if parameters:
        of_all = {name: dict(of) for name, of in file.parameters.items()}
        of_all.setdefault("rotor_contact", {}).update(parameters)
        file = file.model_copy(update={"parameters": of_all})
    return whirl_friction(check_machine(file), FRICTION)


def with_offset(file, sites, lower):
    """Return a machine with the centres of some retainers lower by some metres."""
    p = check_machine(file).parameters["rotor_contact"]
    sign, angle = math.copysign(1.0, p["gravity"]), p["gravity_angle"]
    offset = {f"{sites}.offset_x": lower * sign * math.cos(angle), f"{sites}.offset_y": lower * sign * math.sin(angle)}
    plant = {**file.parameters.get("rotor_contact", {}), **offset}
    return file.model_copy(update={"parameters": {**file.parameters, "rotor_contact": plant}})


def verdict_on(quantity):
    (found,) = judge([quantity], load_criteria(["physics"]), {})
    return found.verdict


@pytest.fixture(scope="module", params=slow_but_first(("blower", "turbo_expander")))
def described(request, tmp_path_factory):
    """Folder of a machine's files, and its friction."""
    folder = tmp_path_factory.mktemp(request.param)
    files_of(request.param, folder)
    return folder, least(folder)


@pytest.mark.parametrize("same", SAME)
def test_an_equivalent_description_has_the_same_whirl_friction(described, same, tmp_path):
    folder, before = described
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    SAME[same](tmp_path)
    after = least(tmp_path)
    assert after.value == pytest.approx(before.value, rel=2e-3)
    assert verdict_on(after) is verdict_on(before) is Judgement.FAILED


def test_whirl_friction_on_rigid_retainers_is_near_that_of_a_rigid_rotor():
    """Forward cross coupling of the stage and damping raise the friction slightly; bending lowers it."""
    file = load_machine(BLOWER / "machine.toml")
    without = least(file.model_copy(update={"stages": ()}))
    assert without.value == pytest.approx(RIGID, rel=0.02)
    assert least(file).value > 1.02 * without.value
    assert_names(without.where, "td_a", "td_b", "0 rpm", f"{file.speed.tripping * 30.0 / math.pi:.0f} rpm")


def test_a_retainer_that_a_fallen_rotor_does_not_reach_counts_for_nothing(tmp_path):
    """A third one of 1 mm between those of 0.2 mm; the file may begin with any of them."""
    files_of("blower", tmp_path)
    before = least(tmp_path)
    wide = {"name": "wide", "z": 0.2, "bearing": "amb_a", "clearance": 1e-3}
    rotor = read(tmp_path / "rotor.toml")
    for sites in ([*rotor["sites"], wide], [wide, *rotor["sites"]]):
        rewritten(lambda made, sites=sites: made | {"sites": sites}, tmp_path)
        after = least(tmp_path)
        assert after.value == pytest.approx(before.value, rel=5e-3)
        assert after.where.split(",")[0] == before.where.split(",")[0]


@pytest.mark.parametrize("share", [-0.5, 0.8])
def test_offset_retainers_change_the_height_of_the_fall(share):
    """By h = 1 + share."""
    file = load_machine(BLOWER / "machine.toml").model_copy(update={"stages": ()})
    low = with_offset(file, "td_?", share * 0.2e-3)
    assert least(low).value == pytest.approx(friction_over_top(1.0 + share), rel=0.02)


@pytest.mark.parametrize(
    ("clearance", "lower", "pairs"),
    [
        (0.6e-3, -0.57e-3, {("other", "td_b")}),
        (0.15e-3, 0.1e-3, {("td_a", "td_b")}),
        (0.15e-3, 0.0, {("other", "td_b")}),
    ],
)
def test_offset_decides_whether_a_fallen_rotor_reaches_a_retainer(clearance, lower, pairs, tmp_path):
    """Beside retainers of 0.2 mm: the lowest points of the other one are at 0.03, 0.25 and 0.15 mm."""
    files_of("blower", tmp_path)
    other = {"name": "other", "z": 0.2, "bearing": "amb_a", "clearance": clearance}
    rewritten(lambda made: made | {"sites": [other, *made["sites"]]}, tmp_path)
    subject = check_machine(with_offset(load_machine(tmp_path / "machine.toml"), "other", lower))
    names = (tuple(sorted(subject.retainers[k] for k in lying.at)) for lying in lying_on(subject))
    assert {pair for pair in names if len(pair) == 2} == pairs


def test_seals_at_the_retainers_lower_the_fall_of_a_machine(tmp_path):
    """By h = 1 - k c/(m g) for a rigid rotor in rigid retainers, each seal with the share of its retainer."""
    files_of("blower", tmp_path)
    rotor, h = check_machine(load_machine(tmp_path / "machine.toml")).rotor, 0.5
    masses = carried_at(rotor, [site.node for site in rotor.sites])
    seals = [
        {"name": f"seal{k}", "z": rotor.shaft.nodes[site.node - 1], "stiffness": (1.0 - h) * mass * 9.81 / 0.2e-3}
        for k, (site, mass) in enumerate(zip(rotor.sites, masses, strict=True))
    ]
    rewritten(lambda made: made | {"seals": seals}, tmp_path)
    held = load_machine(tmp_path / "machine.toml").model_copy(update={"stages": ()})
    assert least(held).value == pytest.approx(friction_over_top(h, most=1.0), rel=0.03)


def test_the_advised_mounts_suffice():
    """The rotor sinks by an eighth of the clearance; a damping of 0.3 to 1.5 times k/sqrt(g/c)."""
    file = load_machine(BLOWER / "machine.toml")
    rotor = check_machine(file).rotor
    carried = max(carried_at(rotor, [site.node for site in rotor.sites]))
    k, pendulum = carried * 9.81 / (0.125 * 0.2e-3), math.sqrt(9.81 / 0.2e-3)
    for share in (0.3, 1.5):
        mounts = {"td_?.housing_mass": 2.5, "td_?.mount_stiffness_?": k, "td_?.mount_damping_?": share * k / pendulum}
        found = least(file, **mounts)
        assert found.value > 1.2 * RIGID
        assert verdict_on(found) is Judgement.MET
        assert not chance(found)


def test_the_compressor_on_its_mounts_meets_the_whirl_friction():
    found = least(load_machine("compressor"))
    assert verdict_on(found) is Judgement.MET
    assert found.value > 1.2 * RIGID


def test_whirl_friction_of_a_machine_is_found_once_for_all_landings(monkeypatch):
    subject, speeds = check_machine(load_machine(BLOWER / "machine.toml")), []
    over_speed = whirl_module.relative_receptances
    monkeypatch.setattr(whirl_module, "relative_receptances", lambda *of: speeds.append(of[1]) or over_speed(*of))
    at_most, at_least = (whirl_friction(subject, friction) for friction in (0.15, 0.05))
    assert at_least == replace(at_most, facts=at_most.facts | {"friction": 0.05})
    assert len(speeds) == len(set(speeds)) > 0


@pytest.mark.parametrize(
    ("friction", "whirling", "verdict"),
    [
        (0.31, 0.0, Judgement.MET),
        (0.31, 12.5, Judgement.FAILED),
        (0.24, 0.0, Judgement.NOT_JUDGED),
        (0.24, 12.5, Judgement.NOT_JUDGED),
    ],
)
def test_whirling_landings_are_judged_only_below_the_whirl_friction(friction, whirling, verdict):
    facts = {"whirl_friction": friction, "friction": FRICTION}
    assert verdict_on(Quantity("landing_backward_whirl", "of 8 landings", whirling, "%", facts)) is verdict


@pytest.mark.parametrize(("on_face", "advised", "other"), [(0.0, "mount_stiffness", "face"), (1.0, "radius", "top")])
def test_advice_is_for_what_the_rotor_lands_on(on_face, advised, other):
    """Mounts do not help a rotor that stands on a face, and a machine without a face has none to enlarge."""
    item = Quantity("whirl_friction", "here", 0.24, "1", ON_RETAINERS | {"on_face": on_face})
    (found,) = (item for item in judge([item], load_criteria(), {}) if item.criterion is not None)
    assert found.verdict is Judgement.FAILED
    assert advised in found.advice
    assert found.criterion is not None
    assert other not in found.advice + found.criterion.what + found.criterion.source
    assert (found.limit, found.criterion.known) == (2.0 * FRICTION, "own")


@pytest.mark.parametrize(
    ("gravity", "falls_onto_a_face", "on_face"),
    [(9.81, False, 0.0), (9.81, True, 0.0), (0.0, True, 1.0), (0.0, False, 0.0)],
)
def test_only_an_upright_rotor_stands_on_a_face(gravity, falls_onto_a_face, on_face):
    """A horizontal rotor with a thrust disc has faces, too, and falls onto its retainers."""
    found = Quantity("whirl_friction", "here", 0.5, "1", {"stiffer": 0.5})
    subject = SimpleNamespace(
        gravity_across=gravity,
        falls_onto_a_face=falls_onto_a_face,
        linear_components=SimpleNamespace(cached=lambda name, find: found),
    )
    assert whirl_friction(subject, FRICTION).facts == {"friction": FRICTION, "on_face": on_face}


def test_whirl_friction_just_below_the_coefficient_leaves_it_to_chance():
    item = Quantity("whirl_friction", "td_a, 0 rpm", 0.24, "1", ON_RETAINERS)
    assert_names(chance(item), "0.15", "0.24", "chance")
    assert verdict_on(item) is Judgement.FAILED
    assert not chance(Quantity("whirl_friction", "td_a, 0 rpm", 0.31, "1", ON_RETAINERS))


@pytest.mark.parametrize(
    ("friction", "whirling", "verdict"),
    [
        (0.24, 0, Judgement.UNANSWERED),
        (0.24, 1, Judgement.UNANSWERED),
        (0.24, 8, Judgement.UNANSWERED),
        (0.31, 0, Judgement.MET),
        (0.31, 1, Judgement.FAILED),
    ],
)
def test_contact_in_whirling_landings_counts_unless_left_to_chance(friction, whirling, verdict, monkeypatch):
    """The first `whirling` of eight landings whirl and reach a stator and a seal; the others do not."""
    landed = iter([True] * whirling + [False] * (8 - whirling))

    def land(subject, inputs, mu, phase):
        whirls = next(landed)
        touched = ("seal",) if whirls else ()
        return landing.Landing(mu, phase, {}, whirls, not whirls, None, touched, touched)

    item = Quantity("whirl_friction", "td_a, 0 rpm", friction, "1", ON_RETAINERS)
    monkeypatch.setattr(landing, "whirl_friction", lambda *_: item)
    monkeypatch.setattr(landing, "worst_inputs", lambda _: {})
    monkeypatch.setattr(landing, "_landed", land)
    measured = {
        found.quantity: found
        for found in landing.result_of(check_machine(load_machine(BLOWER / "machine.toml"))).quantities
    }
    assert [verdict_on(measured[name]) for name in ("landing_failed", "landing_contact_elsewhere")] == [verdict] * 2


@pytest.mark.slow
@pytest.mark.parametrize(("share", "whirl"), [(0.48, 0), (1.6, 4)])
def test_landings_whirl_above_the_whirl_friction_and_not_below_half(share, whirl, monkeypatch):
    monkeypatch.setattr(landing, "LONGEST", 1.5)
    subject = check_machine(load_machine(BLOWER / "machine.toml"))
    friction, inputs = share * whirl_friction(subject, FRICTION).value, worst_inputs(subject)
    landings = [landing._landed(subject, inputs, friction, phase / 4) for phase in range(4)]
    assert sum(item.whirls_backward for item in landings) == whirl
