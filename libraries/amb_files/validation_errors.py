"""Turns each of pydantic's errors into a sentence."""

from __future__ import annotations

import re
import types
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import annotated_types
from pydantic import GetJsonSchemaHandler, Tag, ValidationError
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, ErrorDetails

from amb_files.suggestions import suggest

Location = tuple[int | str, ...]

_KINDS = {
    "bool_type": "true or false",
    "int_type": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "int_parsing": "a whole number",
    "bool_parsing": "true or false",
    "string_type": "a string",
    "finite_number": "a finite number",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a table",
    "model_type": "a table",
    "dataclass_type": "a table",
}
_BOUNDS = {annotated_types.Gt: ">", annotated_types.Ge: ">=", annotated_types.Lt: "<", annotated_types.Le: "<="}
_SIZE = re.compile(r"(\w+) should have (at (?:least|most) \d+ \w+)")  # what pydantic says of lengths
_PATTERN = "String should match pattern "
_WORDS = {"List": "list", "Tuple": "list", "Dictionary": "table"}
_NO_NUMBER = ("float_type", "float_parsing")
_LONGEST = 60  # characters of a value in a message
_UNKNOWN = ("extra_forbidden", "unexpected_keyword_argument")
MOST_SENTENCES, MOST_KEYS = 50, 20  # of a message
_MANY = 3  # unknown keys of a table from which on a single sentence lists them


@dataclass(frozen=True)
class Unit:
    """The unit of a number, in an `Annotated` type; messages show it with the value and the limits."""

    text: str

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return handler(core) | {"unit": self.text}


@dataclass(frozen=True)
class Allowed:
    """Allowed values in words, in an `Annotated` type; messages show these words instead of pydantic's text."""

    text: str


@dataclass(frozen=True)
class _Declared:
    """Declaration of an item of the data: its type, and the metadata from `Annotated` and `Field`."""

    hint: Any
    metadata: tuple[Any, ...] = ()


def sentences(error: ValidationError, form: type[Any], data: object) -> list[str]:
    """Write one sentence for each error, with key, value and allowed range.

    Parameters
    ----------
    error
        Error raised by the validation of `data` against `form`.
    form
        A pydantic model or dataclass.
    data
        The data that were validated: mappings, sequences and scalars.
    """
    by_place: dict[Location, list[ErrorDetails]] = {}
    for details in error.errors():
        by_place.setdefault(_keys(details, data), []).append(details)
    for keys, errors in list(by_place.items()):  # pydantic calls a list too short if its items are invalid
        if errors[0]["type"] == "too_short" and any(other[: len(keys)] == keys != other for other in by_place):
            del by_place[keys]
    unknown_keys: dict[Location, list[Location]] = {}  # by table
    for keys, errors in by_place.items():
        if errors[0]["type"] in _UNKNOWN:
            unknown_keys.setdefault(keys[:-1], []).append(keys)
    summaries = []
    for unknown in unknown_keys.values():
        if len(unknown) >= _MANY:  # not a typo but a file of another kind
            errors = [by_place.pop(keys)[0] for keys in unknown]
            names = ", ".join(_place(keys, data) for keys in unknown[:MOST_KEYS])
            names += f" and {len(unknown) - MOST_KEYS} more" if len(unknown) > MOST_KEYS else ""
            summaries.append(f"unknown keys {names}; {suggest(names, _options(form, errors[0]))}")
    some = islice(by_place.values(), MOST_SENTENCES)
    lines = [*summaries, *(line for errors in some for line in _sentence(errors, form, data).splitlines())]
    more = len(by_place) - MOST_SENTENCES
    return [*lines, f"{more} more mistakes"] if more > 0 else lines


def _sentence(errors: list[ErrorDetails], form: type[Any], data: object) -> str:
    first = errors[0]
    kind, message, keys = first["type"], str(first["msg"]), _keys(first, data)
    place = _place(keys, data)
    if kind == "missing" and isinstance(keys[-1], str):
        return f"{place} is missing"
    if kind in ("union_tag_invalid", "union_tag_not_found") and isinstance(value := _at(data, keys), Mapping):
        tag = str(first["ctx"]["discriminator"]).strip("'")  # the key that says which of several tables this is
        if tag not in value:
            return f"{place}.{tag} is missing"
        kinds = re.findall(r"'(\w+)'", str(first["ctx"].get("expected_tags")))
        return f"{place}.{tag} = {_shortened(value[tag])} is not allowed; {suggest(str(value[tag]), kinds)}"
    if kind in _UNKNOWN:
        return f"unknown key {place}; {suggest(str(keys[-1]), _options(form, first))}"
    metadata = [extra for declared in _declared(form, first["loc"]) for extra in declared.metadata]
    if kind == "value_error":
        message = message.removeprefix("Value error, ")
        if not message.startswith("it must be "):  # complete sentences, one per line
            return "\n".join(_at_place(line, keys, data) for line in message.splitlines())
        allowed = message.removeprefix("it must be ")
    else:
        allowed = " or ".join(dict.fromkeys(_allowed(details, metadata) for details in errors))
    allowed = next((extra.text for extra in metadata if isinstance(extra, Allowed)), allowed)
    value = _at(data, keys)
    if isinstance(value, str) and kind in (*_NO_NUMBER, "value_error") and _unit(metadata) and re.search(r"\d", value):
        allowed += f"{'' if kind in _NO_NUMBER else f', in{_unit(metadata)}'}, written without a unit"
    if isinstance(value, Mapping) and allowed == "a list":
        allowed = f"a list of tables, [[{place}]]"
    unit = _unit(metadata) if isinstance(value, int | float) and not isinstance(value, bool) else ""
    return f"{place or 'it'} = {_shortened(value)}{unit} is not allowed; it must be {allowed}"


def _options(form: type[Any], unknown: ErrorDetails) -> list[str]:
    """Return the keys that are allowed in the table that contains an unknown key."""
    return [key for declared in _declared(form, unknown["loc"][:-1]) for key in _fields(declared.hint)]


def _at_place(sentence: str, keys: Location, data: object) -> str:
    """Return the error message of a form's check with the full key: `diameter = ...` becomes `shaft.diameter = ...`."""
    named = re.match(r"(\w+)(?= (?:=|is missing|is set))", sentence)
    if named:
        return _place((*keys, named[1]), data) + sentence[named.end() :]
    return f"{_place(keys, data)}: {sentence}" if keys else sentence


def _allowed(details: ErrorDetails, metadata: Sequence[Any]) -> str:
    kind = details["type"]
    limits = [f"{sign} {getattr(m, _name(type(m))):g}" for m in metadata for t, sign in _BOUNDS.items() if type(m) is t]
    limits = list(dict.fromkeys(limits))  # a union repeats those of its members
    if limits and kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal"):
        return " and ".join(limits) + _unit(metadata)
    if kind in _NO_NUMBER and (limits or _unit(metadata)):
        return f"a number {' and '.join(limits) or 'in'}{_unit(metadata)}"
    if limits and kind == "finite_number":
        return "finite and " + " and ".join(limits) + _unit(metadata)
    if kind in _KINDS:
        return _KINDS[kind]
    message = str(details["msg"])
    if size := _SIZE.match(message):
        return f"a {_WORDS.get(size[1], size[1].lower())} with {size[2]}"
    message = message.replace(_PATTERN, "a string of the pattern ")
    return message.replace("Input should be ", "").replace("a valid ", "a ").replace("tuple", "list")


def _name(bound: type) -> str:
    return bound.__name__.lower()


def _unit(metadata: Sequence[Any]) -> str:
    return next((f" {extra.text}" for extra in metadata if isinstance(extra, Unit)), "")


def _shortened(value: object) -> str:
    """Return the value as shortened TOML; tables are not written out."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, bool):
        return str(value).lower()
    text = str(list(value)) if isinstance(value, tuple) else repr(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


def _place(keys: Location, data: object) -> str:
    """Return a key path such as `bodies[2].mass (d3)`, where `d3` names the innermost list item that has a name."""
    text, name = "", ""
    for depth, key in enumerate(keys):
        text += f"[{key}]" if isinstance(key, int) else f".{key}" if text else key
        part = _at(data, keys[: depth + 1])
        if isinstance(key, int) and isinstance(part, Mapping) and isinstance(part.get("name"), str):
            name = f" ({part['name']})"
    return text + name


def _keys(details: ErrorDetails, data: object) -> Location:
    """Return the parts of an error's location that exist in the data, and the missing key if there is one.

    pydantic's locations also contain members of unions and names of validators.
    """
    location = details["loc"]
    keys: Location = ()
    for part in location:
        if _has(data, part):
            data, keys = _at(data, (part,)), (*keys, part)
    if details["type"] == "missing" and location[-1:] != keys[-1:]:
        keys = (*keys, location[-1])
    return keys


def _has(data: object, part: int | str) -> bool:
    if isinstance(part, int):
        return isinstance(data, Sequence) and not isinstance(data, str) and part < len(data)
    return isinstance(data, Mapping) and part in data


def _at(data: Any, keys: Location) -> Any:
    for key in keys:
        if not _has(data, key):
            return None
        data = data[key]
    return data


def _declared(form: Any, location: Location) -> list[_Declared]:
    """Return the declarations of a location: one, or several if its type is a union."""
    here = list(_unwrapped(_Declared(form)))
    for part in location:
        tagged = [d for d in here if _is_tagged(d, part)]
        if tagged:
            here = tagged
            continue
        inner = [d for outer in here for d in _member(outer.hint, part)]
        if inner:  # the name of an untagged union member is not a key
            here = inner
    return here


def _is_tagged(declared: _Declared, tag: int | str) -> bool:
    """Return whether a tag selects this member of a union, either as a `Tag` or as the value of a key."""
    kinds = (info.annotation for info in _fields(declared.hint).values() if get_origin(info.annotation) is Literal)
    own = any(isinstance(extra, Tag) and extra.tag == tag for extra in declared.metadata)
    return own or any(tag in get_args(kind) for kind in kinds)


def _member(hint: Any, part: int | str) -> Iterator[_Declared]:
    fields, origin, arguments = _fields(hint), get_origin(hint), get_args(hint)
    if part in fields:
        info = fields[str(part)]
        yield from _unwrapped(_Declared(info.annotation, tuple(info.metadata)))
    elif isinstance(part, int) and origin is tuple and arguments:
        element = arguments[0] if len(arguments) == 2 and arguments[1] is Ellipsis else arguments[part]
        yield from _unwrapped(_Declared(element))
    elif isinstance(part, int) and arguments:
        yield from _unwrapped(_Declared(arguments[0]))
    elif isinstance(part, str) and len(arguments) == 2 and origin is not tuple:
        yield from _unwrapped(_Declared(arguments[1]))


def _unwrapped(declared: _Declared) -> Iterator[_Declared]:
    """Yield the members of a union, with `Annotated` removed."""
    origin = get_origin(declared.hint)
    if origin is Annotated:
        hint, *extras = get_args(declared.hint)
        flat = [m for extra in extras for m in (extra.metadata if isinstance(extra, FieldInfo) else [extra])]
        yield from _unwrapped(_Declared(hint, (*declared.metadata, *flat)))
    elif origin in (Union, types.UnionType):
        for hint in get_args(declared.hint):
            yield from _unwrapped(_Declared(hint, declared.metadata))
    else:
        yield declared


def _fields(hint: Any) -> Mapping[str, FieldInfo]:
    if not isinstance(hint, type):
        return {}
    fields: Mapping[str, FieldInfo] = getattr(hint, "__pydantic_fields__", None) or getattr(hint, "model_fields", {})
    return {info.alias or name: info for name, info in fields.items()}
