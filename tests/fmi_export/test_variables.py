"""Rules of the variable tables."""

import math

import pytest

from fmi_export.building.interface_page import full_description
from fmi_export.interface import Interface, interface, repeated
from fmi_export.model import Model
from fmi_export.variables import Enumeration, enumerated, input_, output, parameter
from tests.support.messages import assert_names, raises_naming

A = parameter("a", "m", "A length", 2.0, minimum=1.0, maximum=3.0)
U = input_("u", "N", "A force")
Y = output("y", "N", "A force", depends_on=("u",))
FAULT = output("fault_code", "1", "Fault", type="Integer")


def test_groups_are_sorted_by_causality_and_keep_their_order_within_it():
    table = interface([Y, U], parameter("b", "1", "B", 0.0), [FAULT, A])
    assert [v.name for v in table.variables] == ["b", "a", "u", "y", "fault_code"]
    assert (table.n_parameters, table.n_inputs, table.n_outputs) == (2, 1, 2)
    assert table.position["y"] == 3
    assert (table.index("parameter", "a"), table.index("input", "u"), table.index("output", "fault_code")) == (1, 0, 1)


def test_a_name_declared_twice_is_refused():
    with raises_naming(ValueError, "twice", "u"):
        interface(U, U)


def test_a_table_out_of_order_is_refused():
    with raises_naming(ValueError, "parameters, inputs, outputs"):
        Interface((U, A))


def test_a_dependency_on_a_variable_that_is_no_input_is_refused():
    with raises_naming(ValueError, "y", "a, w"):
        interface(A, U, output("y", "N", "A force", depends_on=("u", "w", "a")))


def parts(count, initially_depends_on):
    """A table with `count` parts, each with a parameter `k`, and an output that initially depends on some of them."""
    springs = repeated("springs", [(f"s{n}",) for n in range(count)], lambda n: [parameter(f"{n}.k", "N/m", "K", 1.0)])
    return interface(A, U, springs, output("y", "N", "A force", initially_depends_on=initially_depends_on))


def test_initial_dependencies_expand_to_the_variables_of_all_parts():
    table = parts(2, ("u", "springs[*].k", "a"))
    assert table.initial_dependencies == {"y": ("a", "s0.k", "s1.k", "u")}
    assert parts(0, ("u", "springs[*].k")).initial_dependencies == {"y": ("u",)}
    assert interface(U, output("y", "N", "A force", initially_equals="u")).initial_dependencies == {"y": ("u",)}
    assert parts(2, ()).initial_dependencies == {"y": ()}
    assert parts(2, None).initial_dependencies == {}


@pytest.mark.parametrize("name", ["w", "y", "springs[*].c"])
def test_an_initial_dependency_on_an_unset_variable_is_refused(name):
    with raises_naming(ValueError, "y", name):
        parts(2, ("u", name))


def test_an_initial_dependency_on_unknown_parts_is_refused():
    with raises_naming(ValueError, "y", "spring[*].k", "parts"):
        parts(1, ("u", "spring[*].k")).with_all_parts()
    parts(1, ("springs[*].k",)).with_all_parts()


LAW = Enumeration("Law", (("rigid", "a constraint"), ("spring", "")))


def test_an_enumeration_names_the_values_from_zero_on():
    law = parameter("law", "1", "Law", 1, **enumerated(LAW))
    assert (law.type, law.minimum, law.maximum) == ("Integer", 0, 1)
    assert_names(law.describe_range(3.0), "law", "3", "0 (rigid)", "1 (spring)")
    assert full_description(law) == "Law. 0 rigid: a constraint; 1 spring"


@pytest.mark.parametrize("options", [{"maximum": 2}, {"type": "Real"}])
def test_a_range_that_is_not_that_of_the_enumeration_is_refused(options):
    with raises_naming(ValueError, "law", "Integer", "Law"):
        parameter("law", "1", "Law", 1, **(enumerated(LAW) | options))


def test_two_enumerations_of_one_name_are_refused():
    other = Enumeration("Law", (("soft", ""), ("spring", "")))
    with raises_naming(ValueError, "two", "Law"):
        interface(parameter("a", "1", "A", 0, **enumerated(LAW)), parameter("b", "1", "B", 0, **enumerated(other)))


@pytest.mark.parametrize("options", [{}, {"type": "Integer"}])
def test_only_a_boolean_output_can_be_a_warning(options):
    with raises_naming(ValueError, "y", "Boolean"):
        output("y", "1", "Beyond a limit", warning="y is beyond its limit", **options)


def test_a_warning_that_names_an_unknown_variable_is_refused():
    flag = output("flag", "1", "Beyond a limit", type="Boolean", warning="u = {u} N is beyond {w} N and {v} N")
    with raises_naming(ValueError, "flag", "v, w"):
        interface(U, flag)


@pytest.mark.parametrize("start", [0.5, 3.5, math.nan, math.inf])
def test_a_start_value_outside_its_range_is_refused(start):
    with raises_naming(ValueError, "a", f"{start:g} m", ">= 1", "<= 3 m"):
        parameter("a", "m", "A length", start, minimum=1.0, maximum=3.0)


def test_an_unbounded_variable_must_be_finite():
    with raises_naming(ValueError, "a", "inf", "finite"):
        parameter("a", "1", "A number", math.inf)


def test_error_of_an_unknown_name_lists_the_variables():
    with raises_naming(ValueError, "input", "'y'", "u"):
        interface(A, U, Y).index("input", "y")


def test_variability_follows_causality_and_type():
    assert A.variability == "fixed"
    assert parameter("k", "1", "Gain", 1.0, tunable=True).variability == "tunable"
    assert (U.variability, FAULT.variability) == ("continuous", "discrete")


def test_the_canonical_bytes_change_with_every_public_field():
    base = interface(A, U, Y).canonical()
    assert base == interface(A, U, Y).canonical()
    for changed in (
        parameter("a", "mm", "A length", 2.0, minimum=1.0, maximum=3.0),
        parameter("a", "m", "A length", 2.5, minimum=1.0, maximum=3.0),
        parameter("a", "m", "A length", 2.0, minimum=1.0, maximum=4.0),
        parameter("a", "m", "A length", 2.0, minimum=1.0, maximum=3.0, tunable=True),
    ):
        assert interface(changed, U, Y).canonical() != base


def test_a_model_without_a_fault_code_at_the_end_is_refused(lag):
    with raises_naming(ValueError, "mute", "fault_code"):
        Model("mute", "", interface(A, U, Y), lag.initialise, lag.step, 0, 0, ())
