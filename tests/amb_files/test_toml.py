"""TOML checked against a declared form: each mistake is one line with its key, value and what is allowed."""

from __future__ import annotations

from typing import Annotated, Literal

import pytest
from annotated_types import Ge, Gt, Lt
from pydantic import BaseModel, BeforeValidator, ConfigDict, StrictBool, StrictFloat, StrictInt, StrictStr

from amb_files.toml import parse_toml, read_toml, table, validate
from amb_files.validation_errors import Allowed, Unit

ONE = "diameter = 1\n"
ANY = "a number, true, false, or a string with a unit"

Value = Annotated[StrictBool | StrictFloat | StrictStr, Allowed(ANY)]
Lengths = Annotated[
    tuple[Annotated[StrictFloat, Gt(0.0), Unit("m")], ...],
    BeforeValidator(lambda v: v if isinstance(v, list | tuple) else [v]),
]


@table
class Disc:
    name: StrictStr
    node: Annotated[StrictInt, Ge(1)]
    mass: Annotated[StrictFloat, Gt(0.0), Unit("kg")]
    ratio: Annotated[StrictFloat, Gt(-1.0), Lt(0.5)] = 0.3


@table
class Pump:
    diameter: Lengths
    discs: tuple[Disc, ...] = ()
    theory: Literal["timoshenko", "rayleigh"] = "timoshenko"
    inputs: dict[str, dict[str, Value]] | None = None

    def __post_init__(self) -> None:
        if len({disc.node for disc in self.discs}) < len(self.discs):
            raise ValueError("two discs are at one node")
        if len(self.diameter) > 2:
            raise ValueError("diameter = too many is not allowed; it must be one or two")


class Model(BaseModel):
    model_config = ConfigDict(extra="forbid")
    pump: Pump
    width: StrictInt | StrictStr = 1


DISC = '[[discs]]\nname = "d1"\nnode = 1\nmass = 2\n[[discs]]\nname = "d2"\nnode = 2\nmass = 3.0\n'


def load(text: str, form: type = Pump):
    return validate(parse_toml(text, "pump"), form, "pump")


def refused(text: str, form: type = Pump) -> list[str]:
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the callers compare messages
        load(text, form)
    assert "pydantic" not in str(caught.value)
    return [line.removeprefix("pump: ") for line in str(caught.value).splitlines()]


def test_valid_file_becomes_an_instance_of_its_form():
    assert load(ONE + DISC) == Pump((1.0,), (Disc("d1", 1, 2.0), Disc("d2", 2, 3.0)))
    assert load("pump.diameter = [1, 2]\nwidth = 'wide'", Model) == Model(pump=Pump(diameter=[1, 2]), width="wide")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "diameter is missing"),
        ("diameter = 0", "diameter = 0 m is not allowed; it must be > 0 m"),
        ("diameter = [1, 0.0]", "diameter[1] = 0.0 m is not allowed; it must be > 0 m"),
        ("diameter = 'wide'", "diameter = 'wide' is not allowed; it must be > 0 m"),
        ("diameter = nan", "diameter = nan m is not allowed; it must be finite and > 0 m"),
        (ONE + "theory = 'euler'", "theory = 'euler' is not allowed; it must be 'timoshenko' or 'rayleigh'"),
        (ONE + "discs = 3", "discs = 3 is not allowed; it must be a list"),
        (ONE + "discs = [3]", "discs[0] = 3 is not allowed; it must be a table"),
        (ONE + "inputs = []", "inputs = [] is not allowed; it must be a table"),
        (
            ONE + DISC.replace("node = 2", "node = true"),
            "discs[1].node (d2) = true is not allowed; it must be a whole number",
        ),
        (
            ONE + DISC.replace("mass = 3.0", "mass = -3.0"),
            "discs[1].mass (d2) = -3.0 kg is not allowed; it must be > 0 kg",
        ),
        (ONE + DISC + "ratio = 0.5", "discs[1].ratio (d2) = 0.5 is not allowed; it must be > -1 and < 0.5"),
        (ONE + DISC + "mas = 1", "unknown key discs[1].mas (d2); did you mean mass?"),
        (ONE + DISC.replace("mass = 3.0", ""), "discs[1].mass (d2) is missing"),
        (ONE + DISC.replace("node = 2", "node = 1"), "two discs are at one node"),
        (ONE + DISC.replace('"d1"', "1"), "discs[0].name = 1 is not allowed; it must be a string"),
        (ONE + "depth = 2", "unknown key depth; there are diameter, discs, theory, inputs"),
        (ONE + "inputs.a.b = [1, 2]", "inputs.a.b = [1, 2] is not allowed; it must be " + ANY),
        (ONE + "inputs.float.str = {}", "inputs.float.str = a table is not allowed; it must be " + ANY),
    ],
)
def test_mistake_names_key_value_unit_and_limits(text, sentence):
    assert refused(text) == [sentence]


def test_every_mistake_is_one_line():
    assert sorted(refused("diameter = 0\ndepth = 1\ntheory = 3\ndiscs = [1]")) == [
        "diameter = 0 m is not allowed; it must be > 0 m",
        "discs[0] = 1 is not allowed; it must be a table",
        "theory = 3 is not allowed; it must be 'timoshenko' or 'rayleigh'",
        "unknown key depth; there are diameter, discs, theory, inputs",
    ]


def test_sentences_of_a_form_carry_its_place():
    many = "pump.diameter = [1, 1, 1]"
    assert refused(many, Model) == ["pump.diameter = too many is not allowed; it must be one or two"]
    double = "pump.diameter = 1\n" + DISC.replace("[[discs", "[[pump.discs").replace("node = 2", "node = 1")
    assert refused(double, Model) == ["pump: two discs are at one node"]


def test_a_file_of_another_kind_is_told_in_one_sentence():
    assert refused("diameter = 1\nspeed = 1\nstages = []\nscenario = 'drop'") == [
        "unknown keys speed, stages, scenario; there are diameter, discs, theory, inputs"
    ]


def test_pydantic_models_are_checked_alike():
    assert refused("pump.diameter = -1\nwidht = 3\nwidth = 1.5", Model) == [
        "pump.diameter = -1 m is not allowed; it must be > 0 m",
        "width = 1.5 is not allowed; it must be a whole number or a string",
        "unknown key widht; did you mean width?",
    ]


def test_long_values_are_shortened():
    (line,) = refused(ONE + "theory = " + str([0.123456789] * 100))
    assert len(line) < 160


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Disc("d", 1, -2.0), "mass = -2.0 kg is not allowed; it must be > 0 kg"),
        (lambda: Disc(name="d", node=0, mass=2.0), "node = 0 is not allowed; it must be >= 1"),
        (lambda: Disc("d", 1), "mass is missing"),
        (lambda: Pump((1.0,), (Disc("a", 1, 1.0), Disc("b", 1, 1.0))), "two discs are at one node"),
    ],
)
def test_form_made_in_python_raises_the_same_sentence(make, sentence):
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the whole message is compared
        make()
    assert str(caught.value) == sentence


def test_invalid_toml_has_its_line_and_column():
    with pytest.raises(ValueError, match=r"pump is not valid TOML: .*line 2, column"):
        parse_toml("a = 1\nb = \nc = 2", "pump")


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda p: None, "No such file"),
        (lambda p: p.mkdir(), "directory"),
        (lambda p: p.write_bytes(b"a\xff"), r"not UTF-8 text \(byte 1\)"),
    ],
)
def test_unreadable_file_is_refused_with_its_reason(tmp_path, make, reason):
    path = tmp_path / "pump.toml"
    make(path)
    with pytest.raises(ValueError, match=f"pump file cannot be read: .*{reason}"):
        read_toml(path, "pump file")
