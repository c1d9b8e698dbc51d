"""TOML checked against a declared class: each error is one line with key, value and allowed range."""

import time
from dataclasses import field
from typing import Annotated, Literal

import pytest
from annotated_types import Ge, Gt, Lt, MaxLen, MinLen
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    StrictBool,
    StrictFloat,
    StrictInt,
    StrictStr,
    StringConstraints,
)

from amb_files.toml import parse_toml, read_toml, table, validate
from amb_files.validation_errors import MOST_KEYS, MOST_SENTENCES, Allowed, Unit
from tests.support.messages import assert_names, raises_naming

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
    key: Annotated[str, StringConstraints(pattern="^[a-z]+$"), Allowed("a name of lower-case letters")] = "key"
    code: Annotated[str, StringConstraints(pattern="^[0-9]+$", max_length=3)] = "1"
    limits: Annotated[dict[str, float], MinLen(1)] = field(default_factory=lambda: {"x": 1.0})
    steps: Annotated[tuple[float, ...], MinLen(1), MaxLen(2)] = (1.0,)

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


def test_valid_file_becomes_an_instance_of_its_class():
    assert load(ONE + DISC) == Pump((1.0,), (Disc("d1", 1, 2.0), Disc("d2", 2, 3.0)))
    assert load("pump.diameter = [1, 2]\nwidth = 'wide'", Model) == Model(pump=Pump(diameter=[1, 2]), width="wide")


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ("", ("diameter", "missing")),
        ("diameter = 0", ("diameter = 0 m", "> 0 m")),
        ("diameter = [1, 0.0]", ("diameter[1]", "0.0 m", "> 0 m")),
        ("diameter = 'wide'", ("diameter", "'wide'", "number > 0 m")),
        ("diameter = '40 mm'", ("diameter", "'40 mm'", "number > 0 m", "without a unit")),
        (ONE + "[discs]\nname = 'd1'", ("discs", "table", "list", "[[discs]]")),
        ("diameter = nan", ("diameter", "nan m", "finite", "> 0 m")),
        (ONE + "theory = 'euler'", ("theory", "'euler'", "'timoshenko'", "'rayleigh'")),
        (ONE + "discs = 3", ("discs", "3", "list")),
        (ONE + "discs = [3]", ("discs[0]", "3", "table")),
        (ONE + "inputs = []", ("inputs", "[]", "table")),
        (ONE + DISC.replace("node = 2", "node = true"), ("discs[1].node (d2)", "true", "whole number")),
        (ONE + DISC.replace("mass = 3.0", "mass = -3.0"), ("discs[1].mass (d2)", "-3.0 kg", "> 0 kg")),
        (ONE + DISC + "ratio = 0.5", ("discs[1].ratio (d2) = 0.5", "> -1", "< 0.5")),
        (ONE + DISC + "mas = 1", ("discs[1].mas (d2)", "mass")),
        (ONE + DISC.replace("mass = 3.0", ""), ("discs[1].mass (d2)", "missing")),
        (ONE + DISC.replace("node = 2", "node = 1"), ("two discs", "node")),
        (ONE + DISC.replace('"d1"', "1"), ("discs[0].name", "1", "string")),
        (ONE + "depth = 2", ("key depth", "diameter, discs, theory, inputs")),
        (ONE + "key = 'Wrong Key'", ("key = 'Wrong Key'", "it must be a name of lower-case letters")),
        (ONE + "key = 3", ("key = 3", "it must be a name of lower-case letters")),
        (ONE + "code = 'x'", ("code = 'x'", "it must be a string of the pattern '^[0-9]+$'")),
        (ONE + "code = '1234'", ("code = '1234'", "it must be a string with at most 3 characters")),
        (ONE + "limits = {}", ("limits", "it must be a table with at least 1 item")),
        (ONE + "steps = []", ("steps = []", "it must be a list with at least 1 item")),
        (ONE + "steps = [1.0, 2.0, 3.0]", ("steps = [1.0, 2.0, 3.0]", "it must be a list with at most 2 items")),
        (ONE + "inputs.a.b = [1, 2]", ("inputs.a.b", "[1, 2]", ANY)),
        (ONE + "inputs.float.str = {}", ("inputs.float.str", "table", ANY)),
    ],
)
def test_mistake_names_key_value_unit_and_limits(text, facts):
    (line,) = refused(text)
    assert_names(line, *facts)


def test_every_mistake_is_one_line():
    diameter, disc, theory, key = sorted(refused("diameter = 0\ndepth = 1\ntheory = 3\ndiscs = [1]"))
    assert_names(diameter, "diameter = 0 m", "> 0 m")
    assert_names(disc, "discs[0]", "1", "table")
    assert_names(theory, "theory", "3", "'timoshenko'", "'rayleigh'")
    assert_names(key, "key depth", "diameter, discs, theory, inputs")


def test_a_message_is_no_longer_than_a_page():
    *lines, last = refused(ONE + "discs = [" + "1, " * 1000 + "]")
    assert len(lines) == MOST_SENTENCES
    assert last == f"{1000 - MOST_SENTENCES} more mistakes"
    (line,) = refused(ONE + "".join(f"k{n} = 1\n" for n in range(1000)))
    assert_names(line, "k0", f"k{MOST_KEYS - 1} and {1000 - MOST_KEYS} more", "theory")


def test_messages_of_a_validator_name_their_table():
    many = "pump.diameter = [1, 1, 1]"
    (line,) = refused(many, Model)
    assert_names(line, "pump.diameter", "too many", "one or two")
    double = "pump.diameter = 1\n" + DISC.replace("[[discs", "[[pump.discs").replace("node = 2", "node = 1")
    (line,) = refused(double, Model)
    assert_names(line, "pump", "two discs", "node")


def test_a_file_of_another_kind_is_refused_in_one_line():
    (line,) = refused("diameter = 1\nspeed = 1\nstages = []\nscenario = 'drop'")
    assert_names(line, "keys speed, stages, scenario", "diameter, discs, theory, inputs")


def test_pydantic_models_are_checked_alike():
    diameter, width, key = refused("pump.diameter = -1\nwidht = 3\nwidth = 1.5", Model)
    assert_names(diameter, "pump.diameter", "-1 m", "> 0 m")
    assert_names(width, "width", "1.5", "whole number", "string")
    assert_names(key, "widht", "width")


def test_long_values_are_shortened():
    (line,) = refused(ONE + "theory = " + str([0.123456789] * 100))
    assert len(line) < 160


@pytest.mark.parametrize(
    ("make", "facts"),
    [
        (lambda: Disc("d", 1, -2.0), ("mass", "-2.0 kg", "> 0 kg")),
        (lambda: Disc(name="d", node=0, mass=2.0), ("node", "0", ">= 1")),
        (lambda: Disc("d", 1), ("mass", "missing")),
        (lambda: Pump((1.0,), (Disc("a", 1, 1.0), Disc("b", 1, 1.0))), ("two discs", "node")),
    ],
)
def test_instance_made_in_python_is_checked_alike(make, facts):
    with raises_naming(ValueError, *facts):
        make()


def test_invalid_toml_has_its_line_and_column():
    with raises_naming(ValueError, "pump", "TOML", "line 2"):
        parse_toml("a = 1\nb = \nc = 2", "pump")


@pytest.mark.parametrize(
    ("make", "facts"),
    [
        (lambda p: None, ("No such file",)),
        (lambda p: p.mkdir(), ("folder",)),
        (lambda p: [p.mkdir(), (p / "machine.toml").touch()], ("folder with machine.toml",)),
        (lambda p: p.write_bytes(b"a\xff"), ("UTF-8", "byte 1")),
    ],
)
def test_unreadable_file_is_refused_with_its_reason(tmp_path, make, facts):
    path = tmp_path / "pump.toml"
    make(path)
    with raises_naming(ValueError, "pump file", *facts):
        read_toml(path, "pump file")


@pytest.mark.parametrize("text", ["a = 1 #" + 2**22 * "#", 3000 * ("a" + 999 * ".a" + "=1\n")])
def test_a_text_that_takes_long_to_parse_is_refused_at_once(tmp_path, text):
    (path := tmp_path / "base.toml").write_text(text, encoding="utf-8")
    began = time.process_time()
    with raises_naming(ValueError, "scenario base"):
        read_toml(path, "scenario base")
    assert time.process_time() - began < 2.0


def test_dots_in_texts_and_comments_are_not_those_of_keys():
    assert parse_toml(f"a = '{5000 * '.'}' # {1000 * '.'}", "pump") == {"a": 5000 * "."}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be"])
def test_files_have_the_encodings_of_windows_editors(tmp_path, encoding):
    mark = b"\xfe\xff" if encoding == "utf-16-be" else b""
    (tmp_path / "pump.toml").write_bytes(mark + 'name = "Lüfter"\n'.encode(encoding))
    assert read_toml(tmp_path / "pump.toml", "pump") == {"name": "Lüfter"}


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16-le", "utf-32"])
def test_another_encoding_is_refused_with_utf_8(tmp_path, encoding):
    (tmp_path / "pump.toml").write_bytes('name = "Lüfter"\n'.encode(encoding))
    with raises_naming(ValueError, "pump", "save it as UTF-8"):
        read_toml(tmp_path / "pump.toml", "pump")


@pytest.mark.parametrize("text", ["mass = 1,5", "mass = 12,000 # kg", "disc = { mass = 1.234,5 }", "mass =-0,5"])
def test_a_comma_in_a_number_is_named(text):
    number = text.partition("mass =")[2].strip(" }#kg")
    with raises_naming(ValueError, "pump", "line 2", number, "decimal point"):
        parse_toml(f"width = 2\n{text}\n", "pump")


def test_commas_between_numbers_are_no_decimal_commas():
    with pytest.raises(ValueError, match="not valid TOML") as caught:
        parse_toml("nodes = [1,5 mm]\n", "pump")
    assert "decimal" not in str(caught.value)
