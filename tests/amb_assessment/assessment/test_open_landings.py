"""Landings that have not ended, or do not happen: their criteria can be missed, but are not met."""

import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from amb_assessment.assessment.analyses import landing, recovery, rest
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import Quantity
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.runs import worst_inputs
from tests.support.messages import assert_names

BLOWER = Path(__file__).parent / "blower" / "machine.toml"


@pytest.mark.parametrize(("value", "verdict"), [(0.0, Judgement.UNANSWERED), (12.5, Judgement.FAILED)])
def test_an_unfinished_landing_is_missed_or_open_and_never_met(value, verdict):
    item = Quantity("landing_failed", "of 8 landings", value, "%", may_worsen_because="3 of 8 landings have not ended")
    (found,) = judge([item], load_criteria(["physics"]), {})
    assert found.verdict is verdict
    assert (found.reason == item.may_worsen_because) is (verdict is Judgement.UNANSWERED)
    (ended,) = judge([replace(item, value=0.0, may_worsen_because="")], load_criteria(["physics"]), {})
    assert ended.verdict is Judgement.MET


@pytest.mark.parametrize("whirling", [(), (9,), (22,), (9, 22)])
def test_the_force_of_a_backward_whirl_decides_nothing(monkeypatch, whirling):
    """The page of the blower: 56 weights in one landing that whirls, 169 in another of the same machine.

    Twice its 9 shapes as modes are 18, with residual shapes 22.
    """
    forces, kept = {9: 56.0, 22: 169.0}, iter((9, 22))

    def landed(*_, **__):
        n = next(kept)
        touchdown = SimpleNamespace(whirls_backward_at=["rb1"] if n in whirling else [])
        return SimpleNamespace(
            summary=SimpleNamespace(touchdown=touchdown, averaged_contact_force={"rb1": forces[n], "rb2": None})
        )

    monkeypatch.setattr(rest, "simulate", landed)
    (item,) = rest._convergence(assessed_machine_of(load_machine(BLOWER)), 900.0, {}, {})
    assert item.value == pytest.approx(100.0 * (169.0 / 56.0 - 1.0))
    (found,) = judge([item], load_criteria(["physics"]), {})
    assert found.verdict is (Judgement.UNANSWERED if whirling else Judgement.FAILED)
    if whirling:
        assert_names(found.reason, "backward", *(f"{n} shapes" for n in whirling))
    assert judge([replace(item, value=0.0)], load_criteria(["physics"]), {})[0].verdict is not Judgement.FAILED


def test_a_machine_without_gravity_does_not_land():
    file = load_machine(BLOWER).model_copy(update={"gravity": "0 m/s2"})
    result = assess(file, only=["landing", "rest"])
    assert set(result.unanswered) == {"landing", "rest"}
    for reason in result.unanswered.values():
        assert_names(reason, "no gravity", "machine file")
    assert not result.findings


@pytest.mark.slow
def test_relevitation_without_gravity_is_open():
    subject = assessed_machine_of(load_machine(BLOWER).model_copy(update={"gravity": "0 m/s2"}))
    item = next(item for item in recovery.result_of(subject).quantities if item.quantity == "relevitation")
    (found,) = judge([item], load_criteria(["physics"]), {})
    assert found.verdict is Judgement.UNANSWERED
    assert_names(found.reason, "no gravity")


def _swing(end):
    """Return the angle (deg) of "swings up to 24 deg"."""
    return float(end.removeprefix("swings up to ").removesuffix(" deg"))


@pytest.mark.slow
def test_a_landing_runs_to_its_end_or_is_reported_as_unfinished(monkeypatch):
    """The blower rocks in its retainers at full speed, which is an end if the swing stays below 90 degrees."""
    monkeypatch.setattr(landing, "FRICTIONS", (0.15,))
    monkeypatch.setattr(landing, "PHASES", 2)
    monkeypatch.setattr(landing, "chance", lambda least: "")  # another reason for leaving the criterion open
    result = landing.result_of(assessed_machine_of(load_machine(BLOWER)))
    open_ended = [row for row in result.tables[0].rows if row[3] == "not ended"]
    failed = next(item for item in result.quantities if item.quantity == "landing_failed")
    assert bool(open_ended) is bool(failed.may_worsen_because)
    for row in result.tables[0].rows:
        assert row[3] in ("not ended", "backward whirl", "at rest") or _swing(row[3]) < 90.0
    if open_ended:
        assert_names(failed.may_worsen_because, "2 s", f"{len(open_ended)} of 2")


def test_a_landing_that_goes_on_has_the_figures_of_one_run(monkeypatch):
    """It continues from the end of its first part, after its first impacts, to the last bit."""
    subject, starts, runs = assessed_machine_of(load_machine(BLOWER)), [], landing.simulate
    monkeypatch.setattr(
        landing, "simulate", lambda *of, start, **by: starts.append(start) or runs(*of, start=start, **by)
    )
    monkeypatch.setattr(landing, "LONGEST", 0.12)
    at_once, in_two = [], []
    for first, landed in ((0.12, at_once), (0.06, in_two)):
        monkeypatch.setattr(landing, "FIRST", first)
        landed.append(landing._landed(subject, worst_inputs(subject), 0.15, 0.25))
    assert in_two == at_once
    assert in_two[0].heat > 0.0
    assert [start and round(start.time, 9) for start in starts] == [None, None, 0.06]


@pytest.mark.slow
def test_a_landing_on_the_stators_is_not_survived(tmp_path, monkeypatch):
    """Retainers of the blower with 0.6 mm in magnets with an air gap of 0.4 mm."""
    shutil.copytree(BLOWER.parent, tmp_path, dirs_exist_ok=True)
    text = (tmp_path / "rotor.toml").read_text(encoding="utf-8")
    assert text.count("clearance = 0.2e-3") == 2
    (tmp_path / "rotor.toml").write_text(text.replace("= 0.2e-3", "= 0.6e-3"), encoding="utf-8")
    for name, value in (("FRICTIONS", (0.15,)), ("PHASES", 1), ("FIRST", 0.05), ("LONGEST", 0.05)):
        monkeypatch.setattr(landing, name, value)
    result = landing.result_of(assessed_machine_of(load_machine(tmp_path / "machine.toml")))
    found = {
        item.criterion.key: item for item in judge(result.quantities, load_criteria(["physics"]), {}) if item.criterion
    }
    for key in ("landing_survived", "landing_on_retainers_alone"):
        assert found[key].verdict is Judgement.FAILED
        assert found[key].measured.value == 100.0


@pytest.mark.slow
def test_contact_late_in_a_coast_down_is_judged(monkeypatch):
    """The turbo-expander strikes its labyrinth 1.8 s after the loss of power."""
    monkeypatch.setattr(rest, "LONGEST", 2.2)
    subject = assessed_machine_of(load_machine("turbo_expander"))
    found = {item.quantity: item for item in rest.result_of(subject).quantities}
    touched = found["landing_contact_elsewhere"]
    assert touched.value == 100.0
    assert_names(touched.where, "labyrinth")
