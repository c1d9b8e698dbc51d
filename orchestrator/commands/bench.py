"""Commands that measure cost."""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console

from orchestrator.commands.printing import show
from orchestrator.commands.refusals import check_writable, refusing


@click.group()
def bench() -> None:
    """Measure cost, as ratios within one run."""


@bench.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Also draw the comparison, into this folder.")
def contact(as_json: bool, output: Path | None) -> None:
    """Compare contact as a constraint with the classical stiff laws, at equal accuracy."""
    from orchestrator.studies import contact_cost

    with refusing():
        if output is not None:
            check_writable(output, is_folder=True)
        with Console(stderr=True).status("measuring (a first run compiles the models)"):
            data = contact_cost.compare()
        if output is not None:
            output.mkdir(parents=True, exist_ok=True)
            contact_cost.draw(data, output / "contact_cost.png")
    show(data, contact_cost.as_tables, as_json)


COMMANDS = (bench,)
