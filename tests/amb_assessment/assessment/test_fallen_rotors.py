"""Laws under which a machine does not levitate: every criterion that needs a stable loop is not answered."""

from pathlib import Path

import pytest
from machine_variants import read, toml_text

from amb_assessment.assessment.engine.assess import ANALYSES, Needs, assess
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import Quantity
from tests.support.messages import assert_names

BLOWER = str(Path(__file__).parent / "blower" / "machine.toml")
OF_LEVITATION = {name for name, part in ANALYSES.items() if part.needs >= Needs.STABLE_LOOP}
PLANT_ALONE = {"observable", "axial_load", "axial_capacity"}
"""Criteria on positions and static forces, which a controller does not change."""
WEAK = 0.4  # of the gain: less stiffness than the magnets take away


def with_law(machine, folder, change):
    """Write the machine with a change of its law, a channel for each axis."""
    file = load_machine(machine)
    law = read(Path(file.controller))
    axes = [of | {"from": [a], "to": [b]} for of in law["channel"] for a, b in zip(of["from"], of["to"], strict=True)]
    change(axes)
    (folder / "law.toml").write_text(toml_text(law | {"channel": axes}), encoding="utf-8")
    data = file.model_copy(update={"controller": "law.toml"}).model_dump(
        mode="json", exclude_unset=True, exclude_none=True
    )
    path = folder / "machine.toml"
    path.write_text(toml_text(data), encoding="utf-8")
    return path


def weak(axes):
    axes[0]["gain"] *= WEAK


def reversed_sign(axes):
    for axis in axes:
        axis["gain"] *= -1.0


def exchanged_bearings(axes):
    read_at = [axis["from"] for axis in axes]
    for axis, source in zip(axes, read_at[2:] + read_at[:2], strict=True):
        axis["from"] = source


def exchanged_axes(axes):
    for x, y in zip(axes[::2], axes[1::2], strict=True):
        x["from"], y["from"] = y["from"], x["from"]


CHANGES = (weak, reversed_sign, exchanged_bearings, exchanged_axes)


@pytest.mark.slow
@pytest.mark.parametrize("machine", [BLOWER, "compressor"], ids=["blower", "compressor"])
@pytest.mark.parametrize("change", CHANGES)
def test_a_rotor_that_does_not_levitate_meets_no_criterion_of_its_loop(machine, change, tmp_path):
    path = with_law(machine, tmp_path, change)
    found = assess(path)
    verdicts = {item.criterion.key: item.verdict for item in found.findings if item.criterion}
    assert verdicts.pop("stable") is Judgement.FAILED
    judged = {key: verdict for key, verdict in verdicts.items() if verdict is not Judgement.UNANSWERED}
    assert judged.keys() <= PLANT_ALONE
    expected = {"level_one_decrement", "level_one_ratio", "level_two_decrement"}
    assert expected <= found.unevaluated.keys()
    assert set(found.unanswered) == {name for name in OF_LEVITATION if name != "axial_margins"}
    for reason in (*found.unevaluated.values(), *found.unanswered.values()):
        assert_names(reason, "loop is not stable", "rpm")


@pytest.mark.parametrize("quantity", ["decrement", "decrement_anticipated", "cross_coupling_ratio"])
def test_a_loop_unstable_at_another_speed_meets_no_criterion(quantity):
    """A damped range of speeds, above or below the speed at which the rotor falls."""
    quantity_value = Quantity(quantity, "here", 9.0, "1", needs_stable_loop=True)
    for reason, verdict in (("", Judgement.MET), ("it falls at 5000 rpm", Judgement.UNANSWERED)):
        (finding,) = judge([quantity_value], load_criteria(), {}, lambda reason=reason: reason)
        assert (finding.verdict, finding.reason) == (verdict, reason)
