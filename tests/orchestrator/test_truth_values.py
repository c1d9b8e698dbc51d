"""Tables of files refuse `true` and `false` where they need a number."""

from typing import Annotated

import pytest
from pydantic import Field

from amb_assessment.assessment.format.machine_file import Tolerances
from amb_assessment.assessment.format.retainer_bearings import RetainerBearing
from amb_cosim.cosim.system.system_tables import Record
from amb_cosim.cosim.system.tables import Table
from amb_cosim.scenario.scenario import Scenario
from amb_files.toml import validate
from tests.support.messages import raises_naming


class Thing(Table):
    """Numbers in every kind of place, among them keys that pydantic's schemas also have."""

    type: int = 1
    default: float = 0.0
    own: Annotated[float | None, Field(gt=0.0)] = None
    pair: tuple[float, float] = (0.0, 0.0)
    limits: dict[str, float] = Field(default={})
    part: tuple[Record, ...] = ()
    switch: bool = False
    text_or_number: float | str = 0.0


@pytest.mark.parametrize(
    ("form", "data", "place", "allowed"),
    [
        (Thing, {"type": True}, "type", "a whole number"),
        (Thing, {"default": False}, "default", "a number"),
        (Thing, {"own": True}, "own", "a number > 0"),
        (Thing, {"pair": [1, True]}, "pair[1]", "a number"),
        (Thing, {"limits": {"A": True}}, "limits.A", "a number"),
        (Thing, {"part": [{"every": True}]}, "part[0].every", "a whole number"),
        (Thing, {"text_or_number": True}, "text_or_number", "a number or a string"),
        (Scenario, {"Omega": "9 rpm", "end_cycle": True}, "end_cycle", "a number > 0"),
        (Scenario, {"Omega": "9 rpm", "event": [{"cycle": True, "set": {}}]}, "event[0].cycle", "a number"),
        (Tolerances, {"gap": False}, "gap", "a number >= 0"),
        (RetainerBearing, {"balls": True}, "balls", "a whole number"),
    ],
)
def test_truth_values_in_place_of_numbers_are_refused(form, data, place, allowed):
    """Python and pydantic take true as 1."""
    value = str(next(value for value in ("True", "False") if value in str(data))).lower()
    with raises_naming(ValueError, f"a file: {place} = {value} is not allowed; it must be {allowed}"):
        validate(data, form, "a file")


def test_numbers_of_tables_are_read_as_before():
    thing = validate({"type": 3, "default": 2, "pair": [0, 1.5], "limits": {"A": 2}, "switch": True}, Thing, "a file")
    assert (thing.type, thing.default, thing.pair, thing.limits, thing.switch) == (3, 2.0, (0.0, 1.5), {"A": 2.0}, True)
    assert validate({"text_or_number": "x"}, Thing, "a file").text_or_number == "x"
