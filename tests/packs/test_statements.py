"""The statements of the thesis: complete, well formed, computable."""

import inspect
import re

import pytest

from amb_analysis.studies import STUDIES
from amb_cosim.scenario.scenario import packaged_scenarios
from source_check.evaluation import alternatives, computations
from source_check.quantities import quantities_of_runs, quantities_of_studies
from source_check.statements import load_statements, selected

FIGURES = {2: 8, 3: 9, 4: 21, 5: 6, 6: 20}
TABLES = {2: 4, 3: 4}


@pytest.fixture(scope="module")
def statements():
    return load_statements("bath_thesis")


@pytest.mark.parametrize(("kind", "numbers"), [("Fig.", FIGURES), ("Table", TABLES)])
def test_every_figure_and_table_has_a_statement(statements, kind, numbers):
    named = {match[1] for s in statements.statement if (match := re.match(rf"{re.escape(kind)} (\d\.\d+)", s.where))}
    expected = {f"{chapter}.{n}" for chapter, count in numbers.items() for n in range(1, count + 1)}
    assert expected - named == set()


def test_every_source_exists_and_is_used(statements):
    used = {name for s in statements.statement for name in (s.source, s.converged)} | {
        way.source for s in statements.statement for way in (*computations(s, statements), *alternatives(s, statements))
    }
    assert set(statements.sources) - used == set()
    for source in statements.sources.values():
        assert source.scenario in packaged_scenarios() or source.study in {*STUDIES, "model_inputs"}


def test_every_quantity_exists_and_takes_its_arguments(statements):
    for s in statements.statement:
        for way in (*computations(s, statements), *alternatives(s, statements)):
            of = quantities_of_runs if statements.sources[way.source].scenario else quantities_of_studies
            function, _ = of(statements.quantities)[way.request.quantity]
            inspect.signature(function).bind(None, **dict(way.request.arguments))


# Conversions, formulas of the thesis with its own numbers, and what follows from geometry in contact.
IDENTITIES = (
    *("synchronous_force", "coil_cutoff", "negative_stiffness", "current_stiffness"),
    *("rolling_ratio", "whirl_at_end", "force_at_touch", "smallest_force"),
)
READ_INTO = re.compile(r"\bread as\b|\baxis of the figure\b|\btick\b|\bupper limits\b")


def test_a_statement_that_any_model_meets_is_a_definition(statements):
    definitions = {s.key for s in statements.statement if s.definition}
    assert {s.key for s in statements.statement if s.quantity in IDENTITIES} | {"fig4_8.radius"} == definitions


def test_a_number_read_into_words_is_marked_as_inferred(statements):
    """Numbers for words, ends of axes, and comparisons of limits are no statements of the thesis."""
    silent = [s.key for s in statements.statement if READ_INTO.search(f"{s.what} {s.because}") and not s.inferred]
    assert silent == []
    for key in ("fig4_11.force_rb2", "fig4_13.force_rb2", "fig4_14.settled_rb2", "fig3_8.radius", "fig6_14.mb1"):
        assert next(s for s in statements.statement if s.key == key).inferred


def test_a_limit_that_is_read_off_a_curve_has_a_floor(statements):
    """No force at all would keep the limits of Fig. 4.14."""
    limits = [
        s for s in statements.statement if s.where in ("Fig. 4.14", "Fig. 6.6") and s.unit and s.relation == "below"
    ]
    assert len(limits) == 6
    assert [s.key for s in limits if s.floor != 0.5 * s.value] == []


def test_half_of_the_stated_value_is_not_reproduced(statements):
    loose = [s.key for s in statements.statement if s.relation == "equal" and s.tolerance > 0.25 and s.quantity]
    assert loose == []


def test_forces_are_judged_on_the_converged_rig(statements):
    """Figures 4.6 to 4.21 have a column for the rig whose modes reach beyond those of six planes."""
    forces = [s for s in statements.statement if s.quantity == "peak_force"]
    assert forces
    for s in forces:
        converged, thesis = statements.sources[s.converged], statements.sources[s.source]
        assert (converged.scenario, converged.rotor_file) == (thesis.scenario, "bath_rig")


def test_an_unknown_selection_is_refused(statements):
    with pytest.raises(ValueError, match=r"only = fig4_99 is not allowed; did you mean fig4_9"):
        selected(statements, ["fig4_99"])
