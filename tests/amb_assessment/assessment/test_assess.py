"""An assessment of a machine: its verdicts, its page, and parts that cannot be answered."""

import json

import pytest

from amb_analysis.linear.loop import Loop
from amb_assessment.assessment.engine import assess as room
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.format.criteria import unread
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import QUANTITIES
from amb_assessment.assessment.page.page import write_data, write_page
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from tests.support.messages import assert_names

DRIVING = """
inputs = ["mb1.x", "mb1.y", "mb2.x", "mb2.y"]
outputs = ["mb1.i_x", "mb1.i_y", "mb2.i_x", "mb2.i_y"]
sample_time = "100 us"
limits = ["-6.5 A", "5 A"]

[[channel]]
from = ["mb1.x", "mb1.y", "mb2.x", "mb2.y"]
to = ["mb1.i_x", "mb1.i_y", "mb2.i_x", "mb2.i_y"]
gain = -3.1e4
blocks = [
  { type = "lead", frequency = "470 Hz", phase = "76 deg" },
  { type = "notch", frequency = "645 Hz", damping = 0.4, depth = 0.25 },
  { type = "notch", frequency = "1.89 kHz", damping = 0.25, depth = 0.63 },
]
"""  # without a low-pass

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def compressor():
    """In some parts; tests/docs/test_code_blocks.py has all of them, which the page on assessments writes."""
    return assess("compressor", only=["closed_loop", "unbalance", "vibration"])


def test_control_that_destabilises_modes_that_runs_leave_out_is_missed(tmp_path):
    """Lead and notches at 100 us drive modes from 2.4 kHz on, which the two modes of the runs do not include."""
    law = tmp_path / "lead.toml"
    law.write_text(DRIVING, encoding="utf-8")
    machine = load_machine("compressor")
    others = {name: values for name, values in machine.parameters.items() if name != "rolac_controller"}
    changed = machine.model_copy(update={"controller": str(law), "parameters": others})
    result = assess(changed, only=["closed_loop"]).failed
    (missed,) = (item.measured for item in result if item.measured.quantity == "spectral_radius")
    assert 2400.0 < missed.facts["frequency"] < 6000.0
    assert missed.value > 1.01
    of_runs = Loop(assessed_machine_of(changed).run_components)
    assert of_runs.poles(machine.speed.highest).stability.is_stable


def test_unbalance_of_each_mode_has_its_place_and_sums_to_the_whole(compressor):
    (part,) = (part for part in compressor.parts if part.key == "unbalance")
    (table,) = (table for table in part.result.tables if table.title == "Unbalance of each mode")
    whole = 2.0 * 6350.0 * compressor.facts["mass"] / compressor.facts["N_mc"]
    for _, places in table.rows:
        amounts = [float(place.split(" g mm at ")[0]) for place in places.split(", ")]
        assert sum(map(abs, amounts)) == pytest.approx(whole, rel=0.01)


def test_separation_margins_name_the_unbalance_they_belong_to(compressor):
    """The note of each margin has the amounts and places of its case in the table of placed unbalances."""
    (part,) = (part for part in compressor.parts if part.key == "unbalance")
    (table,) = (table for table in part.result.tables if table.title == "Unbalance of each mode")
    placed = dict(table.rows)
    margins = [f.measured for f in part.findings if f.measured.quantity == "separation_margin"]
    assert margins
    for measured in margins:
        case = measured.where.split(", ")[1]
        assert placed[case] in measured.note


def test_curves_of_decrement_and_frequency_of_a_mode_share_a_label(compressor):
    (part,) = (part for part in compressor.parts if part.key == "closed_loop")
    frequency, damping = ([curve for curve in of.curves if curve.style == "lines"] for of in part.result.panels)
    assert [curve.name for curve in damping] == [curve.name for curve in frequency[: len(damping)]]
    for curve in frequency:
        assert float(curve.name.split(" Hz ")[0]) == pytest.approx(curve.y[-1], abs=0.5)


def test_linear_response_bounds_vibration_in_co_simulation(compressor):
    part_of = {part.key: part for part in compressor.parts}
    used = [item.measured.value for item in part_of["vibration"].findings]
    assert 0.5 < max(used) < 10.0


@pytest.mark.parametrize(("key", "facts"), [("closed_loop", ("damped",)), ("unbalance", ("9000 rpm", "undamped"))])
def test_tables_of_modes_say_how_they_relate_to_the_undamped_speeds(compressor, key, facts):
    """The same mode has one speed without damping, one in the loop at one speed, and one as a peak of the response."""
    (part,) = (part for part in compressor.parts if part.key == key)
    (note,) = (note for note in part.result.notes if "`critical_map`" in note)
    assert_names(note, *facts)


def test_page_and_data_hold_every_verdict(compressor, tmp_path):
    pytest.importorskip("plotly")
    page = write_page(compressor, tmp_path).read_text(encoding="utf-8")
    assert "not checked against the standard" in page
    assert page.index(compressor.conclusion) < page.index("<table")
    assert f"Of the {len(compressor.criteria)} criteria, {unread(compressor.criteria)} were written without" in page
    data = json.loads(write_data(compressor, tmp_path).read_text(encoding="utf-8"))
    assert list(data["parts"]) == [part.key for part in compressor.parts]
    unjudged = [item.measured for part in compressor.parts for item in part.findings if item.criterion is None]
    assert all(QUANTITIES[item.quantity].title for item in unjudged)
    assert all(item.title in page for item in unjudged)


def test_a_failing_part_is_unanswered_and_the_others_run(monkeypatch):
    def broken(subject):
        raise ValueError("the drawing is wet")

    monkeypatch.setitem(room.ANALYSES, "free_modes", room.Analysis("Free modes", broken))
    result = assess("compressor", only=["free_modes", "closed_loop"])
    assert result.unanswered == {"free_modes": "the drawing is wet"}
    assert result.parts[1].findings


def test_an_error_of_the_program_does_not_look_like_a_limit_of_the_machine(monkeypatch):
    def broken(subject):
        return [][1]

    monkeypatch.setitem(room.ANALYSES, "free_modes", room.Analysis("Free modes", broken))
    result = assess("compressor", only=["free_modes", "closed_loop"])
    assert_names(result.unanswered["free_modes"], "program", "report", "IndexError", "test_assess.py, line")
    assert result.parts[1].findings


def test_an_unknown_part_is_refused():
    with pytest.raises(ValueError, match="did you mean landing"):
        assess("compressor", only=["landng"])
    assert "landing" in room.ANALYSES


def test_every_missed_criterion_of_the_expander_has_advice():
    result = assess("turbo_expander", only=["closed_loop", "unbalance"])
    assert {"critical_in_range", "level_two_decrement"} <= {item.criterion.key for item in result.failed}
    assert not result.unanswered
    assert all(item.advice for item in result.failed)
