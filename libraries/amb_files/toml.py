"""Reads TOML and checks it against a declared form; each error is a line with key, value and allowed range.

The form of a file is declared once, as types with limits and units:

    @table
    class Body:
        name: StrictStr
        mass: Annotated[StrictFloat, Gt(0.0), Unit("kg")]

    @table
    class Rotor:
        bodies: tuple[Body, ...] = ()

    rotor = validate(read_toml(path, name), Rotor, name := f"rotor file {path}")

An invalid file raises a ValueError such as

    rotor file pump.toml: bodies[0].mass (impeller) = -1.0 kg is not allowed; it must be > 0 kg
    rotor file pump.toml: unknown key bodies[1].mas (seal); did you mean mass?

Indices in brackets count from 0. The text in parentheses is the `name` of the table at this index, if it has one.
"""

from __future__ import annotations

import re
import tomllib
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Callable
from functools import wraps
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, TypeVar, dataclass_transform

from pydantic import ConfigDict, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as pydantic_dataclass

from amb_files.atomic import is_special
from amb_files.validation_errors import sentences

T = TypeVar("T")

LARGEST = 64 * 2**20  # bytes of a file
FILES = 12  # of a folder, in a message
LARGEST_TOML = 4 * 2**20  # characters, which take seconds to parse
DEEPEST = 100  # levels of tables and lists
MOST_DOTS = 5e7  # sum of the squares of the dots of all keys, which is the time to parse them
LINE = re.compile(r"\(at line (\d+)")
SEPARATED = re.compile(r"=\s*([+-]?\d[\d.]*,\d+)")
NO_KEY = re.compile(r"[,=\[\]{}#\n]")  # separators of keys

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True)


def parse_toml(text: str, name: str) -> dict[str, Any]:
    """Parse TOML.

    Parameters
    ----------
    text
        Content of the file.
    name
        Its name in messages, such as `scenario drop`.

    Raises
    ------
    ValueError
        If the text is not valid TOML (the message shows line and column), if it is longer than `LARGEST_TOML`, or if
        its tables are nested too deeply.
    """
    if len(text) > LARGEST_TOML:
        sizes = f"{len(text) / 2**20:.1f} MB; it must have <= {LARGEST_TOML >> 20} MB"
        raise ValueError(f"{name} cannot be read: it has {sizes}")
    too_deep = ValueError(f"{name} is not allowed: its tables and lists are nested more than {DEEPEST} levels deep")
    if sum(part.count(".") ** 2 for part in NO_KEY.split(text)) > MOST_DOTS:
        raise too_deep
    try:
        data = tomllib.loads(text)
    except RecursionError as error:
        raise too_deep from error
    except ValueError as error:  # a TOMLDecodeError, or from int() for thousands of digits
        raise ValueError(f"{name} is not valid TOML: {error}{_separators(text, str(error))}") from error
    inner: list[Any] = [data]
    for _ in range(DEEPEST):
        lists = [part.values() if isinstance(part, dict) else part for part in inner if isinstance(part, dict | list)]
        inner = [part for parts in lists for part in parts]
    if inner:
        raise too_deep
    return data


def _separators(text: str, error: str) -> str:
    """Return a hint if the line with an error contains a number with a decimal comma or thousands separators."""
    at, lines = LINE.search(error), text.splitlines()
    number = SEPARATED.search(lines[int(at[1]) - 1]) if at is not None and int(at[1]) <= len(lines) else None
    return "" if number is None else f"; {number[1]} has a comma: numbers take a decimal point and no other separators"


def read_toml(source: Path | Traversable, name: str) -> dict[str, Any]:
    """Read a TOML file.

    Parameters
    ----------
    source
        The file, or a resource of a package.
    name
        Its name in messages, such as `rotor file pump.toml`.

    Raises
    ------
    ValueError
        If the file cannot be read or is not valid TOML.
    """
    return parse_toml(read_text(source, name), name)


def read_text(source: Path | Traversable, name: str, largest: int = LARGEST) -> str:
    """Return the text of a file without its byte order mark; for arguments and errors see `read_bytes`.

    The file is UTF-8 or, as editors and shells of Windows write it, UTF-16 with a byte order mark.
    """
    content = read_bytes(source, name, largest)
    encoding = "utf-16" if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) else "utf-8-sig"
    try:
        text = content.decode(encoding)
    except UnicodeDecodeError as error:
        what = encoding.removesuffix("-sig").upper()
        raise ValueError(
            f"{name} cannot be read: it is not {what} text (byte {error.start}); save it as UTF-8"
        ) from error
    if "\0" in text:
        raise ValueError(f"{name} cannot be read: it contains zero bytes, as UTF-16 and UTF-32 do; save it as UTF-8")
    return text


def read_bytes(source: Path | Traversable, name: str, largest: int = LARGEST) -> bytes:
    """Return the content of a file with at most `largest` bytes; for other arguments and errors see `read_toml`."""
    try:
        if isinstance(source, Path):
            if source.is_dir():
                files = ", ".join(sorted(file.name for file in source.glob("*.toml"))[:FILES])
                raise ValueError(f"{name} cannot be read: it is a folder{files and f' with {files}'}")
            if is_special(source):
                raise ValueError(f"{name} cannot be read: it is not a regular file")
            size = source.stat().st_size
            if size > largest:
                raise ValueError(f"{name} cannot be read: it has {size >> 20} MB; it must have <= {largest >> 20} MB")
        return source.read_bytes()
    except OSError as error:
        raise ValueError(f"{name} cannot be read: {error.strerror or error}") from error


def validate(data: object, form: type[T], name: str) -> T:
    """Check data against a form and return it as an instance of that form.

    Parameters
    ----------
    data
        Result of `read_toml`, or a part of it.
    form
        A class declared with `table`, or a pydantic model.
    name
        Name of the data in messages; it begins every line.

    Raises
    ------
    ValueError
        If the data are malformed; the message has one line for each error.
    """
    try:
        return TypeAdapter(form).validate_python(data)
    except ValidationError as error:
        raise ValueError("\n".join(f"{name}: {line}" for line in sentences(error, form, data))) from error


@dataclass_transform(frozen_default=True)
def table(form: type[T]) -> type[T]:
    """Declare the form of a TOML table as a frozen dataclass that checks its fields.

    Unknown keys, NaN and infinity are not allowed. Making an invalid instance in Python raises the same ValueError as
    reading an invalid file.
    """
    checked: Any = pydantic_dataclass(config=STRICT, frozen=True)(form)
    checked.__init__ = _raising_sentences(checked.__init__, checked)
    return checked


def _raising_sentences(init: Callable[..., None], form: type[Any]) -> Callable[..., None]:
    names = list(form.__dataclass_fields__)

    @wraps(init)
    def __init__(self: Any, *values: Any, **named: Any) -> None:
        if len(values) > len(names):
            raise TypeError(f"{form.__name__} takes {len(names)} values but {len(values)} were given")
        settings = dict(zip(names, values, strict=False)) | named
        try:
            init(self, **settings)
        except ValidationError as error:
            raise ValueError("\n".join(sentences(error, form, settings))) from error

    return __init__
