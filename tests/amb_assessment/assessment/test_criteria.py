"""Criteria as data: formulas, zones, sources, and errors that name the fault."""

import math
import re
from dataclasses import replace
from itertools import cycle
from pathlib import Path

import pytest
from click.testing import CliRunner

from amb_assessment.assessment import commands
from amb_assessment.assessment.engine import assess
from amb_assessment.assessment.engine.assess import Assessment, PartResult, chosen_parts
from amb_assessment.assessment.engine.conclusion import by_criterion, conclusion_of, failures
from amb_assessment.assessment.engine.findings import Finding, Judgement, judge
from amb_assessment.assessment.format.criteria import (
    RELIABILITIES,
    Criterion,
    check_criteria,
    criteria_by_file,
    load_criteria,
    own_criteria,
    packaged_criteria,
    unread,
)
from amb_assessment.assessment.format.expressions import evaluate, names_in
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.format.quantities import QUANTITIES, AnalysisResult, Quantity, check_declared, declare
from amb_cosim.commands.cli import main
from tests.support.messages import assert_names, raises_naming

ABOUT = {"key": "own", "what": "w", "quantity": "overload", "source": "me", "known": "own"}
MARGIN = {"quantity": "separation_margin", "unit": "%"}
MACHINE = {"N_min": 7000.0, "N_mc": 9000.0, "N_trip": 9900.0}


def of_api(key):
    return next(item for item in load_criteria(["api_617"]) if item.key == key)


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("1 + 2 * 3 ** 2", 19.0),
        ("min(25.4, 25.4 * sqrt(12000 / N))", 12.7),
        ("N > 1 and not N < 2", 1.0),
        ("-N / 4", -12e3),
    ],
)
def test_a_formula_evaluates_as_in_algebra(formula, value):
    assert evaluate(formula, {"N": 48000.0}) == pytest.approx(value)
    assert names_in(formula) <= {"N"}


@pytest.mark.parametrize(
    ("formula", "facts"),
    [
        ("M + 1", ("M", "N")),
        ("1 / 0", ("division", "zero")),
        ("9 ** 9 ** 9", ("exponent", "64")),
        ("__import__('os')", ("allowed",)),
        ("N.real", ("allowed",)),
        ("1 +", ("formula",)),
        ("(" * 300, ("formula",)),
        ("min()", ("min", "0", "2")),
        ("max(1)", ("max", "1", "2")),
        ("sqrt(1, 2)", ("sqrt", "2", "one")),
        ("(0 - N) ** 0.5", ("-1 ** 0.5",)),
        ("sqrt(0 - N)", ("formula",)),
        ("10 ** 64 * 10 ** 64 * 10 ** 64 * 10 ** 64 * 10 ** 64", ("finite",)),
        ("1e308 * 10", ("finite",)),
        # as integers these have millions of digits; one more level would take hours
        ("(((((9 ** 64) ** 64) ** 64) ** 64) ** 64) ** 64", ("finite",)),
        *(
            (formula, ("formula", "not"))
            for formula in ("min(1, x)", "min(x, 1)", "max(1, x)", "x < 1", "not x", "1 if x else 0", "x ** 0")
        ),
    ],
)
def test_error_names_the_fault_in_a_formula(formula, facts):
    with raises_naming(ValueError, *facts):
        evaluate(formula, {"N": 1.0, "x": math.nan})


def test_each_operand_of_a_formula_is_evaluated_once():
    """A second evaluation at every level would double the time sixty times."""
    assert evaluate("**".join("1" * 60), {}) == 1.0
    assert evaluate("2 ** 3 ** 2", {}) == 512.0


def test_no_packaged_criterion_claims_that_a_standard_was_read():
    criteria = load_criteria()
    assert len(criteria) > 15
    assert not [item.key for item in criteria if item.known == "read"]
    assert all(item.source for item in criteria)


@pytest.mark.parametrize(
    ("amplification", "below", "above"),
    [(2.5, 0.0, 10.0), (5.0, 17 * (1 - 1 / 3.5), 10 + 17 * (1 - 1 / 3.5)), (100.0, 16.0, 26.0)],
)
def test_separation_margins_match_a_hand_calculation(amplification, below, above):
    facts = {**MACHINE, "AF": amplification, "N_c": 5000.0}
    assert of_api("separation_below").applies(facts)
    assert of_api("separation_below").limit_of(facts) == pytest.approx(below, abs=1e-12)
    facts["N_c"] = 11000.0
    assert of_api("separation_above").applies(facts)
    assert not of_api("separation_below").applies(facts)
    assert of_api("separation_above").limit_of(facts) == pytest.approx(above)


def test_an_amplification_below_2_5_requires_no_margin():
    within = Quantity("separation_margin", "here", -5.0, "%", {"AF": 2.4, "N_c": 8000.0})
    sharp = Quantity("separation_margin", "here", -5.0, "%", {"AF": 2.6, "N_c": 8000.0})
    assert [item.verdict for item in judge([within], load_criteria(), MACHINE)] == [Judgement.NOT_JUDGED]
    assert [item.verdict for item in judge([sharp], load_criteria(), MACHINE)] == [Judgement.FAILED]


@pytest.mark.parametrize(
    ("changed", "facts"),
    [
        (MARGIN | {"limit": "foo"}, ("'foo'", "N_mc")),
        (MARGIN | {"limit": "1", "when": "N_mcc > 1"}, ("'N_mcc'", "N_mc")),
        ({"limit": "1 / AF", "quantity": "landing_heat", "unit": "J"}, ("'AF'", "weight")),
        ({"quantity": "mode_reech"}, ("'mode_reech'", "mode_reach")),
        ({"quantity": "mode_reach"}, ("unit = '1'", "mode_reach", "%")),
        ({"quantity": "probe_displacement", "unit": "mm"}, ("'mm'", "um")),
        *(({"failure": failure}, ("failure",)) for failure in ("{valeu}", "{value.__class__}", "{value", "{}")),
        # formulas of the machine alone are evaluated
        (MARGIN | {"limit": "sqrt(0 - N_mc)"}, ("formula",)),
        (MARGIN | {"limit": "1", "when": "N_mc / 0 > 1"}, ("formula",)),
    ],
)
def test_a_check_names_the_fault_of_a_criterion(changed, facts):
    with raises_naming(ValueError, "criterion own", *facts):
        check_criteria([Criterion(**ABOUT | {"limit": "1"} | changed)], MACHINE)


def test_a_check_accepts_packaged_criteria_and_the_variables_of_a_quantity():
    check_criteria(load_criteria(), MACHINE)
    check_criteria([Criterion(**ABOUT | MARGIN, limit="1 / AF")], MACHINE)  # AF is that of a mode


def test_a_zone_ends_below_its_limit():
    zones = Criterion(**ABOUT, zones={"A": 3.0, "B": 4.0}, accepted="B", beyond="D")
    assert [zones.zone_of(value) for value in (2.9, 3.0, 4.0)] == ["A", "B", "D"]
    assert zones.is_met(3.99, {})
    assert not zones.is_met(4.0, {})


@pytest.mark.parametrize(("relation", "met"), [("below", [True, True, False]), ("above", [False, True, True])])
def test_a_value_equal_to_its_limit_meets_it(relation, met):
    criterion = Criterion(**ABOUT, limit="N_min / 70000", relation=relation)
    assert [criterion.is_met(value, MACHINE) for value in (0.0999, 0.1, 0.1001)] == met


@pytest.mark.parametrize(
    ("value", "printed"), [(100.04, "100.04 %"), (104.0, "104 %"), (99.99, "99.99 %"), (99.999, "100 %")]
)
def test_a_value_that_misses_its_limit_is_not_rounded_to_it(value, printed):
    """100 % (at most 100 %) would say that it is met; a value that meets it may be rounded to it."""
    used = Criterion(**ABOUT | {"quantity": "clearance_used"}, unit="%", limit="100")
    (result,) = judge([Quantity("clearance_used", "here", value, "%")], [used], {})
    assert (result.verdict is Judgement.FAILED, result.value_text) == (value > 100.0, printed)


def test_a_formula_of_an_unknown_variable_leaves_its_criterion_open():
    (result,) = judge([Quantity("overload", "here", 1.0)], [Criterion(**ABOUT, limit="2 * N_mx")], MACHINE)
    assert result.verdict is Judgement.UNANSWERED
    assert "N_mc" in result.reason


def test_criteria_without_a_value_or_a_decision_are_listed_by_key():
    items = [Quantity("overload", "here", 1.0), Quantity("overload", "open", 1.0, may_worsen_because="nothing falls")]
    limits = {"own": "2 * N_mx", "open": "2", "failed": "0.5"}
    criteria = [Criterion(**ABOUT | {"key": key}, limit=limit) for key, limit in limits.items()]
    part = PartResult("part", "Part", AnalysisResult(), tuple(judge(items, criteria, MACHINE)))
    result = Assessment(None, MACHINE, tuple(criteria), (part,))
    assert list(result.unevaluated) == ["own"]
    assert sorted(result.undecided) == ["open", "own"]
    assert result.undecided["open"] == "nothing falls"


def test_an_own_criterion_whose_quantity_nothing_has_is_unanswered():
    """Its limit would be lost without a word. Those of a standard do not apply to parts that a machine lacks."""
    machine, own = load_machine("turbo_expander"), Criterion(**ABOUT, limit="1")
    parts = tuple(PartResult(name, name, AnalysisResult(), ()) for name in chosen_parts(machine))
    whole = Assessment(machine, MACHINE, (own,), parts, own=(own,))
    assert_names(whole.unevaluated["own"], "overload")
    assert whole.as_dict()["unevaluated"] == whole.unevaluated
    assert_names(whole.conclusion, "Undecided", "0 of 1", "1 unanswered")
    assert not replace(whole, parts=parts[:1]).unmeasured  # another part may have it
    assert not replace(whole, own=()).unmeasured


def test_own_criteria_are_those_of_files_outside_packages(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(
        'standard = "ours"\n[[criterion]]\nkey = "own"\nwhat = "w"\nquantity = "overload"\nlimit = "1"\n'
        'source = "me"\nknown = "own"\n'
    )
    assert [item.key for item in own_criteria(criteria_by_file(["iso_14839", file]))] == ["own"]
    assert own_criteria(criteria_by_file()) == own_criteria(criteria_by_file(["iso_14839"])) == ()


def test_a_criterion_without_a_source_judges_nothing():
    criteria = load_criteria(["iso_14839"])
    (result,) = judge([Quantity("current_demand", "here", 900.0, "%")], criteria, MACHINE)
    assert (result.verdict, result.limit_text) == (Judgement.NOT_JUDGED, "–")
    assert result.criterion.key == "current_zone"
    assert "No source" in result.reason


@pytest.mark.parametrize(
    ("changes", "facts"),
    [
        ({"known": "missing", "limit": "1"}, ("source",)),
        ({"key": "Wrong Key", "limit": "1"}, ("key", "Wrong Key")),
        ({}, ("limit", "zones")),
        ({"limit": "1", "zones": {"A": 1.0}}, ("limit", "zones")),
        ({"zones": {"A": 1.0}, "accepted": "B", "beyond": "D"}, ("accepted",)),
        ({"zones": {"A": 3.0, "B": 2.0}, "accepted": "B", "beyond": "D"}, ("ascend",)),
        ({"limit": "1 +"}, ("formula",)),
        ({"zones": {"A": math.nan}, "accepted": "A", "beyond": "D"}, ("zones.A", "finite")),
    ],
)
def test_an_incomplete_criterion_is_refused(changes, facts):
    with raises_naming(ValueError, *facts):
        Criterion(**ABOUT | changes)


def test_a_quantity_is_declared_once_and_computed():
    """In the module that declares it or in another analysis: it has its name twice there at least."""
    with raises_naming(ValueError, "mode_reach", "twice"):
        declare("mode_reach", "%")
    sources = "".join(path.read_text(encoding="utf-8") for path in Path(assess.__file__).parents[1].rglob("*.py"))
    assert not [name for name in QUANTITIES if sources.count(f'"{name}"') < 2]


def test_a_dimensionless_criterion_needs_no_unit():
    (result,) = judge([Quantity("overload", "here", 0.9, "1")], [Criterion(**ABOUT, limit="1")], {})
    assert (result.verdict, result.limit_text) == (Judgement.MET, "at most 1")


@pytest.mark.parametrize("declared", [("mode_reech", "%"), ("mode_reach", "1")])
def test_a_computed_quantity_that_criteria_cannot_name_is_an_error(declared):
    with raises_naming(LookupError, *declared):
        check_declared(*declared, {})


def test_criteria_are_read_from_a_user_file(tmp_path):
    path = tmp_path / "works.toml"
    path.write_text(
        'standard = "works standard"\n[[criterion]]\nkey = "probe"\nwhat = "quiet"\nquantity = "probe_displacement"\n'
        'unit = "um"\nlimit = "10"\nsource = "our own"\nknown = "own"\nadvice = "balance"\n'
    )
    (criterion,) = load_criteria([path])
    assert criterion.where == "works standard"
    (result,) = judge([Quantity("probe_displacement", "here", 11.0, "um")], [criterion], {})
    assert (result.verdict, result.advice, result.limit_text) == (Judgement.FAILED, "balance", "at most 10 µm")
    with raises_naming(ValueError, "api_618", "api_617"):
        load_criteria(["api_618"])


def test_a_critical_speed_in_the_range_is_a_sentence_with_speed_range_and_amplification():
    machine = MACHINE | {"N_min": 9600.0, "N_mc": 12000.0}
    inside = Quantity("separation_margin", "mode 2", -3.304, "%", {"AF": 3.2, "N_c": 11604.0})
    ((_, sentence),) = failures(judge([inside], load_criteria(["api_617"]), machine))
    assert_names(sentence, "11,604 rpm", "9600 to 12,000 rpm", "3.2", "2.5")


def test_a_failure_without_a_number_has_its_words_in_place_of_it():
    unstable = Quantity("sensitivity_varied", "K_i 0.9", 1e3, "1", shown="without bound")
    findings = judge([unstable], load_criteria(["physics"]), MACHINE)
    ((case, sentence),) = failures(findings)
    assert_names(sentence, "without bound", "5 allowed", "K_i 0.9")
    assert "1000" not in sentence + case.value_text


def test_the_sentence_of_every_packaged_criterion_has_its_number_and_its_limit():
    """A limit of 0.15 and a value of 0.17 differ from all other numbers in these sentences."""
    for criterion in load_criteria():
        if criterion.known == "missing":
            assert not criterion.failure
            continue
        names = ["N_min", "N_mc", "N_trip", "mass", "grade", *QUANTITIES[criterion.quantity].variables]
        quantity = Quantity(criterion.quantity, "at the end", 0.17, criterion.unit)
        found = Finding(quantity, criterion, Judgement.FAILED, 0.15, facts=dict.fromkeys(names, 3.0))
        limit = "2.5" if criterion.key == "critical_in_range" else "0.15"  # of the amplification, not of the margin
        number = "3 rpm" if criterion.key == "critical_in_range" else "0.17"
        assert_names(found.sentence, number, limit)


def test_temperatures_are_shown_in_degrees_celsius():
    """Limits are in K, as all inputs; readers see °C in figures and summaries, too."""
    limit = Criterion(**ABOUT | {"quantity": "retainer_temperature", "unit": "K"}, limit="373.15")
    (found,) = judge([Quantity("retainer_temperature", "at rb1", 353.15, "K")], [limit], MACHINE)
    assert (found.value_text, found.limit_text) == ("80 °C", "at most 100 °C")


def test_sources_of_packaged_criteria_name_no_code():
    for item in load_criteria([*packaged_criteria()]):
        assert not re.search(r"\bamb_\w+\.\w", item.source), item.key


def test_the_advice_of_a_packaged_criterion_needs_no_other():
    """A page has only the advice of what failed, so none may refer to another."""
    for item in (item for item in load_criteria([*packaged_criteria()]) if item.known != "missing"):
        assert len(item.advice.split()) > 4, item.key
        assert not re.match(r"(As|Like|See|The same)\b", item.advice), item.key


def test_a_criterion_fails_by_the_worst_of_its_cases():
    """Above a limit the smallest value is the worst, below one the largest."""
    values = [Quantity("overload", f"at {value:g}", value) for value in (1.0, 3.0, 2.0)]
    for relation, worst in (("above", "at 1"), ("below", "at 3")):
        limit = {"above": "2.5", "below": "1.5"}[relation]
        findings = judge(values, [Criterion(**ABOUT, limit=limit, relation=relation)], MACHINE)
        ((case, sentence),) = failures(findings)
        assert case.measured.where == worst
        assert_names(sentence, worst, "2 cases")


@pytest.mark.parametrize(
    ("verdicts", "failed_parts", "facts"),
    [
        ({"a": "FAILED", "b": "UNANSWERED", "c": "MET"}, {}, ("Not yet", "1 of 3", "1 unanswered")),
        ({"a": "MET", "b": "UNANSWERED"}, {}, ("Undecided", "1 of 2", "1 unanswered")),
        ({"a": "MET"}, {"rest": "no sites"}, ("Undecided", "1 of 1", "rest")),
        ({"a": "MET", "b": "MET"}, {}, ("Yes", "2")),
        ({"a": "NOT_JUDGED"}, {}, ("No verdict",)),
    ],
)
def test_the_answer_counts_criteria(verdicts, failed_parts, facts):
    criteria = {key: Criterion(**ABOUT | {"key": key}, limit="1") for key in verdicts}
    found = [
        Finding(Quantity("overload", "here", 2.0), criteria[key], Judgement[name]) for key, name in verdicts.items()
    ]
    assert_names(conclusion_of(found, failed_parts), *facts)
    assert_names(conclusion_of(found, failed_parts, ["closed_loop"]), "closed_loop")


def test_cases_of_a_criterion_count_once():
    cases = [
        Finding(Quantity("overload", "here", 2.0), Criterion(**ABOUT, limit="1"), v)
        for v in (Judgement.MET, Judgement.FAILED)
    ]
    assert by_criterion(cases) == {"own": Judgement.FAILED}


def test_a_limit_that_nobody_checked_says_so():
    unchecked = [text for known, text in RELIABILITIES.items() if known in ("secondary", "recalled")]
    assert all("not checked against the standard" in text for text in unchecked)


def test_the_page_lists_all_quantities_with_units_and_variables():
    page = (Path(__file__).parents[3] / "docs" / "reference" / "criteria_file.md").read_text(encoding="utf-8")
    rows = [
        line.split("|")[1:-1] for line in page.partition("| quantity | unit |")[2].splitlines() if line[:3] == "| `"
    ]
    listed = {
        name: (unit.strip(), set(re.findall(r"`(\w+)`", further)))
        for names, units, further in rows
        for name, unit in zip(re.findall(r"`(\w+)`", names), cycle(units.split(",")), strict=False)
    }
    assert listed == {name: (declared.unit, set(declared.variables)) for name, declared in QUANTITIES.items()}


def test_readme_page_and_help_state_how_many_criteria_nobody_could_check():
    """As `assess --check` prints it; a criterion of our own has no standard."""
    criteria, root = load_criteria(), Path(__file__).parents[3]
    counts = str(len(criteria)), str(unread(criteria))
    sentence = "written without access to the text of their standard"
    texts = {
        "README": (root / "README.md").read_text(encoding="utf-8"),
        "assess.md": (root / "docs" / "how-to" / "assess.md").read_text(encoding="utf-8"),
        "assess --help": commands.assess.help,
    }
    printed = CliRunner().invoke(main, ["assess", "compressor", "--check"]).output
    assert_names(printed, f"{counts[0]} criteria, {counts[1]} of them", "without access to the standard")
    for text in texts.values():
        words = " ".join(text.split()).replace("*", "")
        before, found, _ = words.partition(sentence)
        assert found
        assert_names(before[-200:], *counts)
    own = [Criterion(**ABOUT, limit="1").model_copy(update={"known": k}) for k in ("own", "read", "recalled")]
    assert unread(own) == 1
