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
    parts(1, ("springs[*].k",)).with_all_parts()


LAW = Enumeration("Law", (("rigid", "a constraint"), ("spring", "")))


def test_an_enumeration_names_the_values_from_zero_on():
    law = parameter("law", "1", "Law", 1, **enumerated(LAW))
    assert (law.type, law.minimum, law.maximum) == ("Integer", 0, 1)
    assert_names(law.describe_range(3.0), "law", "3", "0 (rigid)", "1 (spring)")
    assert full_description(law) == "Law. 0 rigid: a constraint; 1 spring"


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


def law(name="law", law=LAW, **options):
    return parameter(name, "1", "Law", 0, **(enumerated(law) | options))


OTHER_LAW = Enumeration("Law", (("soft", ""), ("spring", "")))
WARNING = "u = {u} N is beyond {w} N and {v} N"
REFUSED = [
    (lambda: interface(U, U), ("twice", "u")),
    (lambda: Interface((U, A)), ("parameters, inputs, outputs",)),
    (lambda: interface(A, U, output("y", "N", "A force", depends_on=("u", "w", "a"))), ("y", "a, w")),
    *((lambda name=name: parts(2, ("u", name)), ("y", name)) for name in ("w", "y", "springs[*].c")),
    (lambda: parts(1, ("u", "spring[*].k")).with_all_parts(), ("y", "spring[*].k", "parts")),
    (lambda: law(maximum=2), ("law", "Integer", "Law")),
    (lambda: law(type="Real"), ("law", "Integer", "Law")),
    (lambda: interface(law("a"), law("b", OTHER_LAW)), ("two", "Law")),
    (lambda: output("y", "1", "Beyond a limit", warning="y is beyond its limit"), ("y", "Boolean")),
    (lambda: output("y", "1", "Beyond a limit", warning="y is high", type="Integer"), ("y", "Boolean")),
    (lambda: interface(U, output("flag", "1", "", type="Boolean", warning=WARNING)), ("flag", "v, w")),
    *(
        (
            lambda start=start: parameter("a", "m", "", start, minimum=1.0, maximum=3.0),
            (f"a = {start:g} m", ">= 1", "<= 3 m"),
        )
        for start in (0.5, 3.5, math.nan, math.inf)
    ),
    (lambda: parameter("a", "1", "A number", math.inf), ("a", "inf", "finite")),
    (lambda: interface(A, U, Y).index("input", "y"), ("input", "'y'", "u")),
    (lambda: Model("mute", "", interface(A, U, Y), None, None, 0, 0, ()), ("mute", "fault_code")),
]


@pytest.mark.parametrize(("declare", "facts"), REFUSED)
def test_a_wrong_declaration_is_refused_with_the_reason(declare, facts):
    with raises_naming(ValueError, *facts):
        declare()
