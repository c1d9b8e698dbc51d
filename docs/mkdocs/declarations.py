"""MkDocs hook: writes reference pages from declarations.

{{ keys of MODULE.CLASS }}       the keys of a TOML file, as classes declare them and the texts below fields tell
{{ names of MODULE: A, B }}      the documentation of these functions and classes of a module, by mkdocstrings; without
                                 a list, of all public ones
{{ outcomes of PACK }}           a table of the pack's scenarios: outcome, robust or fragile, what flips it
{{ statements }}                 those of the thesis, by the tables that `amb-cosim report` left in results/report
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from importlib import import_module
from inspect import isclass, isfunction
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args, get_type_hints

from pydantic import TypeAdapter

Schema = Mapping[str, Any]

KEYS = re.compile(r"^\{\{ keys of ([\w.]+)\.(\w+) \}\}$", re.MULTILINE)
NAMES = re.compile(r"^\{\{ names of ([\w.]+)(?:: ([\w, ]+))? \}\}$", re.MULTILINE)
OUTCOMES = re.compile(r"^\{\{ outcomes of (\w+) \}\}$", re.MULTILINE)
STATEMENTS = re.compile(r"^\{\{ statements \}\}$", re.MULTILINE)
REPORT = Path(__file__).parents[2] / "results/report/report.md"
FACADE = "amb_cosim"  # names what other packages have
TYPES = {
    "string": "text",
    "number": "number",
    "integer": "whole number",
    "boolean": "true or false",
    "null": "",
}
LIMITS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
VALUE = {"string", "number", "integer", "boolean"}  # a number, or a text with a unit, of a variable of any type


def on_page_markdown(markdown: str, **_: object) -> str:
    """Return the page with what its lines in double braces ask for."""
    markdown = KEYS.sub(lambda found: keys_of(getattr(import_module(found[1]), found[2])), markdown)
    markdown = NAMES.sub(lambda found: "\n\n".join(names_of(found[1], found[2])), markdown)
    markdown = OUTCOMES.sub(lambda found: outcomes_of(found[1]), markdown)
    return STATEMENTS.sub(lambda _: statements(), markdown)


def outcomes_of(pack: str) -> str:
    """Return a table of a pack's runs with their outcomes, and what flips those that are fragile."""
    from amb_sweeps.stored_robustness import load_robustness

    rows = []
    for name, one in load_robustness(pack).items():
        flips = "; ".join(f"{changed}: {outcome}" for changed, outcome in one.flips.items())
        rows.append(f"| `{name}` | {one.outcome} | {one.verdict} | {flips} |")
    return "\n".join(["| run | outcome | | what flips it |", "| --- | --- | --- | --- |", *rows])


def statements() -> str:
    """The tables of the report's verdicts, or how to get them where no report has been made."""
    if not REPORT.exists():
        return "The tables are here once `amb-cosim report` has run in the folder of this project."
    return REPORT.read_text(encoding="utf-8")


def names_of(module: str, listed: str | None = None) -> Iterator[str]:
    """The directives of mkdocstrings for functions and classes of a module: those listed, or all that it offers."""
    offered = import_module(module)
    for name in getattr(offered, "__all__", offered.__dir__()) if listed is None else listed.split(", "):
        one = getattr(offered, name)
        if isfunction(one) or isclass(one):
            is_own = module == FACADE or one.__module__.startswith(f"{module}.")  # else of a pack, or of sweeps
            package = module if is_own else one.__module__
            yield f"::: {package}.{name}"


def keys_of(form: type[Any]) -> str:
    """Return the sections of a file's form: a pydantic model or dataclass, and those that it holds."""
    schema = TypeAdapter(form).json_schema()
    forms: dict[str, Schema] = schema.get("$defs", {})
    meanings = {one.__name__: meanings_of(one) for one in _forms_in(form)}
    sections = [_section(schema, meanings[form.__name__])]
    done: list[tuple[str, str]] = []
    waiting = list(_tables("", schema))
    while waiting:
        path, name = waiting.pop(0)
        if name not in [other for _, other in done]:
            places = [place for place, _ in (*waiting, *done)]
            title = f"`{path}` ({name})" if path in places else f"`{path}`"
            sections.append(f"## {title}\n\n" + _section(forms[name], meanings[name]))
            waiting = [*_tables(path.strip("[]"), forms[name]), *waiting]
            done.append((path, name))
    return "\n\n".join(sections)


def meanings_of(form: type[Any]) -> dict[str, str]:
    """Return what the keys of a form mean: the docstrings below its fields, and below those that it inherits."""
    found: dict[str, str] = {}
    for one in reversed(form.__mro__[:-1]):
        if one.__module__.partition(".")[0] not in ("pydantic", "builtins"):
            body = ast.parse(textwrap.dedent(inspect.getsource(one))).body[0].body  # type: ignore[attr-defined]
            for field, text in pairwise(body):
                if (
                    isinstance(field, ast.AnnAssign)
                    and isinstance(text, ast.Expr)
                    and isinstance(text.value, ast.Constant)
                ):
                    found[_key_of(one, field.target.id)] = " ".join(str(text.value.value).split())  # type: ignore[union-attr]
    return found


def _key_of(form: type[Any], field: str) -> str:
    """The key of a field in a file, which may have another name than in Python."""
    declared = getattr(form, "model_fields", {}).get(field)
    return declared.alias if declared is not None and declared.alias else field


def _forms_in(form: type[Any]) -> set[type[Any]]:
    """The form and those that it holds, however deep."""
    found: set[type[Any]] = set()
    waiting: list[Any] = [form]
    while waiting:
        one = waiting.pop()
        if isclass(one) and (hasattr(one, "model_fields") or is_dataclass(one)) and one not in found:
            found.add(one)
            waiting += get_type_hints(one).values()
        waiting += get_args(one)
    return found


def _section(schema: Schema, meanings: Mapping[str, str]) -> str:
    """The docstring and the table of keys of one form."""
    text = re.sub(r"\n\nRaises\n-+\n.*", "", schema.get("description", ""), flags=re.DOTALL)
    required = schema.get("required", ())
    rows = [_row(key, meanings.get(key, ""), value, key in required) for key, value in schema["properties"].items()]
    head = ["| key | meaning | type | unit | default | allowed |", "| --- " * 6 + "|"]
    return "\n".join([*([text, ""] if text else []), *head, *rows])


def _row(key: str, meaning: str, schema: Schema, required: bool) -> str:
    leaves = list(_leaves(schema))
    units = dict.fromkeys(leaf["unit"] for leaf in leaves if "unit" in leaf)
    limits = dict.fromkeys(f"{sign} {leaf[name]:g}" for leaf in leaves for name, sign in LIMITS.items() if name in leaf)
    choices = [f"`{choice}`" for leaf in leaves for choice in leaf.get("enum", ())]
    default = "required" if required else _default(schema)
    return (
        f"| `{key}` | {meaning} | {_type(schema)} | {', '.join(units)} | {default} | {', '.join([*limits, *choices])} |"
    )


def _leaves(schema: Schema) -> Iterator[Schema]:
    """The schema and the parts of which its values consist, without other tables."""
    yield schema
    parts = [*schema.get("anyOf", ()), *schema.get("oneOf", ()), *schema.get("prefixItems", ())]
    for part in (
        *parts,
        *(schema[key] for key in ("items", "additionalProperties") if isinstance(schema.get(key), dict)),
    ):
        yield from _leaves(part)


def _type(schema: Schema) -> str:
    """What a key holds, in words."""
    if "$ref" in schema:
        return "table"
    if "anyOf" in schema or "oneOf" in schema:
        parts = [*schema.get("anyOf", ()), *schema.get("oneOf", ())]
        if {part.get("type") for part in parts} >= VALUE:
            return "value"
        return " or ".join(dict.fromkeys(filter(None, map(_type, parts))))
    if schema.get("type") == "array":
        inside = schema.get("items", {})
        return f"list of {_plural(_type(inside))}" if inside else "list"
    if schema.get("type") == "object":
        inside = schema.get("additionalProperties")
        return f"table of {_plural(_type(inside))}" if isinstance(inside, dict) else "table"
    return TYPES[schema["type"]]


def _plural(noun: str) -> str:
    head, of, rest = noun.partition(" of ")
    return f"{head}s{of}{rest}"


def _default(schema: Schema) -> str:
    """The default of a key; nothing where it is empty, stands for "not given", or is a table with keys of its own."""
    value = schema.get("default")
    if value in (None, "", [], {}) or isinstance(value, dict) or (schema.get("minimum", value) != value and not value):
        return ""
    return f"`{str(value).lower() if isinstance(value, bool) else value}`"


def _tables(path: str, schema: Schema) -> Iterator[tuple[str, str]]:
    """The tables in a form: their place in the file, in TOML's brackets, and the names of their forms."""
    for key, value in schema["properties"].items():
        place = f"{path}.{key}" if path else key
        for leaf in _leaves(value):
            if "$ref" in leaf:
                name = leaf["$ref"].rpartition("/")[2]
                is_list = any(part.get("type") == "array" for part in _leaves(value))
                named = "additionalProperties" in value
                yield (f"[[{place}]]" if is_list else f"[{place}.NAME]" if named else f"[{place}]"), name
