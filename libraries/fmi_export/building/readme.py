"""Keeps the interface table in a model's README equal to its variable table.

    python -m fmi_export.building.readme amb_cosim.models:amb_actuator fmus/amb_actuator/README.md

rewrites the text between the two marker comments of that file.
"""

from __future__ import annotations

import importlib
from pathlib import Path

import click

from fmi_export.model import Model
from fmi_export.variables import LARGEST, Variable

BEGIN = "<!-- interface table: begin -->"
END = "<!-- interface table: end -->"
DIGITS = ".12g"


def interface_table(model: Model) -> str:
    """Return a Markdown table of every variable of `model`, in the order of the value references."""
    rows = ["| name | causality | type | unit | start | allowed | description |", "| --- " * 7 + "|"]
    rows += [_row(v) for v in model.interface.variables]
    return "\n".join(rows)


def full_description(v: Variable) -> str:
    """Return the description of a variable with the meaning of its values and its warning."""
    values = f". {v.enumeration.in_words()}" if v.enumeration else ""
    warning = f". Warning: {v.warning}" if v.warning else ""
    return f"{v.description}{values}{warning}"


def with_table(readme: str, table: str) -> str:
    """Return the text of a README with `table` between its two markers.

    Raises
    ------
    ValueError
        If the file does not contain each marker once, in order.
    """
    head, begin, rest = readme.partition(BEGIN)
    _, end, tail = rest.partition(END)
    if not (begin and end) or BEGIN in tail or END in head + tail:
        raise ValueError(f"the README must contain {BEGIN!r} and then {END!r}, once each")
    return f"{head}{BEGIN}\n\n{table}\n\n{END}{tail}"


def _row(v: Variable) -> str:
    causality = f"tunable {v.causality}" if v.tunable else v.causality
    start = "" if v.causality == "output" else v.literal(v.start, DIGITS)
    low = f">= {v.literal(v.minimum, DIGITS)}" if v.minimum > -LARGEST else ""
    high = f"<= {v.literal(v.maximum, DIGITS)}" if v.maximum < LARGEST else ""
    allowed = ", ".join(bound for bound in (low, high) if bound)
    kind = "Enumeration" if v.enumeration else v.type
    if v.enumeration:
        allowed, start = "", start and v.enumeration.names[int(v.start)]
    description = full_description(v).replace("|", "\\|")
    return f"| `{v.name}` | {causality} | {kind} | {v.unit} | {start} | {allowed} | {description} |"


@click.command(help=__doc__)
@click.argument("source", metavar="MODULE:FUNCTION")
@click.argument("readme", type=click.Path(exists=True, dir_okay=False, path_type=Path))
def main(source: str, readme: Path) -> None:
    module, _, function = source.partition(":")
    model, _ = getattr(importlib.import_module(module), function)()
    readme.write_text(with_table(readme.read_text(encoding="utf-8"), interface_table(model)), encoding="utf-8")


if __name__ == "__main__":
    main()
