"""The statements of the thesis: complete, well formed, computable."""

from __future__ import annotations

import inspect
import re

import pytest

from amb_cosim.assessment.evaluation import alternatives, reading_of, ways
from amb_cosim.assessment.quantities import quantities_of_runs, quantities_of_studies
from amb_cosim.assessment.statements import load_statements, selected
from amb_cosim.scenario.scenario import packaged_scenarios
from amb_cosim.studies import STUDIES

FIGURES = {2: 8, 3: 9, 4: 21, 5: 6, 6: 20}
TABLES = {2: 4, 3: 4}


@pytest.fixture(scope="module")
def statements():
    return load_statements("bath_thesis")


@pytest.mark.parametrize(("kind", "numbers"), [("Fig.", FIGURES), ("Table", TABLES)])
def test_no_figure_and_no_table_is_left_out(statements, kind, numbers):
    named = {match[1] for s in statements.statement if (match := re.match(rf"{re.escape(kind)} (\d\.\d+)", s.where))}
    expected = {f"{chapter}.{n}" for chapter, count in numbers.items() for n in range(1, count + 1)}
    assert expected - named == set()


def test_every_source_exists_and_is_used(statements):
    used = {s.source for s in statements.statement} | {
        way.source for s in statements.statement for way in (*ways(s, statements), *alternatives(s, statements))
    }
    assert set(statements.sources) - used == set()
    for source in statements.sources.values():
        assert source.scenario in packaged_scenarios() or source.study in {*STUDIES, "model_inputs"}


def test_every_quantity_exists_and_takes_its_arguments(statements):
    for s in statements.statement:
        for way in (*ways(s, statements), *alternatives(s, statements)):
            of = quantities_of_runs if statements.sources[way.source].scenario else quantities_of_studies
            function, _ = of(statements.quantities)[way.request.quantity]
            inspect.signature(function).bind(None, **dict(way.request.arguments))


def test_a_factor_on_the_unbalances_is_a_reading(statements):
    assert reading_of(statements.sources["fig5_5"])[0] == "all unbalances times 1.44"


def test_a_chapter_and_a_figure_can_be_selected(statements):
    assert {s.group.partition("_")[0][-1] for s in selected(statements, ["ch4"])} == {"4"}
    assert {s.group for s in selected(statements, ["fig4_9", "table3_1"])} == {"fig4_9", "table3_1"}


def test_a_selection_that_is_not_there_is_refused(statements):
    with pytest.raises(ValueError, match=r"--only fig4_99 is not allowed; did you mean fig4_9"):
        selected(statements, ["fig4_99"])
