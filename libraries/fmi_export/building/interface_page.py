"""Writes the reference page of a model's interface in Markdown: variables, faults and warnings.

    python -m fmi_export.building.interface_page amb_cosim.export.models:amb_actuator page.md

The page inside an FMU (`documentation`) shows the same tables.
"""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click

from fmi_export.model import FAULT_NOT_FINITE, FAULT_RANGE, FAULT_STEP_SIZE, Model
from fmi_export.variables import LARGEST, Variable

HEADINGS = {"parameter": "Parameters", "input": "Inputs", "output": "Outputs"}
CODE = re.compile(r"(`[^`]*`)")


@dataclass(frozen=True)
class PageTable:
    """A table with a title; text between backticks in a cell is a name."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def tables(model: Model) -> list[PageTable]:
    """Return the tables of a model: its variables by causality, its faults and, if it has any, its warnings."""
    header = ("name", "type", "unit", "start", "allowed", "description")
    of = model.interface.of
    page_tables = [
        PageTable(title, header, tuple(_cells(v) for v in of(kind)))  # type: ignore[arg-type]
        for kind, title in HEADINGS.items()
    ]
    page_tables.append(PageTable("Faults", ("fault_code", "meaning"), _faults(model)))
    warnings = tuple((f"`{v.name}`", sentence(v.warning)) for v in of("output") if v.warning)
    if warnings:
        page_tables.append(PageTable("Warnings", ("output", "logged when it becomes true"), warnings))
    return page_tables


def interface_page(model: Model) -> str:
    """Return the reference page of a model in Markdown."""
    parts = [f"# Interface of {model.name}", f"{model.description}. Generated from the table of variables."]
    for table in tables(model):
        parts += [f"## {table.title}", _markdown(table)]
    return "\n\n".join(parts) + "\n"


def full_description(v: Variable) -> str:
    """Return the description of a variable, followed by the meaning of its values if these are enumerated."""
    return f"{v.description}. {v.enumeration.in_words()}" if v.enumeration else v.description


def sentence(template: str) -> str:
    """Return a sentence in which backticks enclose the names of variables."""
    return re.sub(r"\{([^}]+)\}", r"`\1`", template)


def outside_code(cell: str, escape: Callable[[str], str]) -> str:
    """Return a cell with `escape` applied to the text outside backticks."""
    return "".join(part if CODE.fullmatch(part) else escape(part) for part in CODE.split(cell))


def _cells(v: Variable) -> tuple[str, ...]:
    low = f">= {v.literal(v.minimum, '.12g')}" if v.minimum > -LARGEST else ""
    high = f"<= {v.literal(v.maximum, '.12g')}" if v.maximum < LARGEST else ""
    start = "" if v.causality == "output" else v.literal(v.start, ".12g")
    allowed = ", ".join(bound for bound in (low, high) if bound)
    if v.enumeration:
        allowed, start = "", start and v.enumeration.names[int(v.start)]
    kind = ("tunable " if v.tunable else "") + ("Enumeration" if v.enumeration else v.type)
    return f"`{v.name}`", kind, "" if v.unit == "1" else v.unit, start, allowed, full_description(v)


def _faults(model: Model) -> tuple[tuple[str, str], ...]:
    local = [(str(code), sentence(message)) for code, message in sorted(model.faults.items())]
    return (
        *local,
        (str(FAULT_STEP_SIZE), "the step size is not positive or not finite"),
        (f"{FAULT_RANGE} + r", "the parameter or input with value reference r is outside its range or not a number"),
        (f"{FAULT_NOT_FINITE} + r", "the output with value reference r is outside its range or not finite"),
    )


def _markdown(table: PageTable) -> str:
    rows = [table.header, ("---",) * len(table.header)]
    rows += [tuple(outside_code(cell, _escaped) for cell in row) for row in table.rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def _escaped(text: str) -> str:
    return re.sub(r"([|*])", r"\\\1", text).replace("<", "&lt;")


@click.command(help=__doc__)
@click.argument("source", metavar="MODULE:FUNCTION")
@click.argument("page", type=click.Path(dir_okay=False, path_type=Path))
def main(source: str, page: Path) -> None:
    module, _, function = source.partition(":")
    model, _ = getattr(importlib.import_module(module), function)()
    page.write_text(interface_page(model), encoding="utf-8")


if __name__ == "__main__":
    main()
