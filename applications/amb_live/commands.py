"""Command that writes the live rig, a page that runs the FMUs in a browser."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli import main
from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import ROTOR, output
from amb_files.atomic import check_writable


@click.command()
@click.argument("scenario", required=False)
@ROTOR
@output("Page to write.", "rig.html")
@click.option("--only", is_flag=True, help="Include only SCENARIO, without the other scenarios.")
@click.option("--docs", default="", metavar="ADDRESS", help="Address of the documentation's docs folder, for links.")
@click.option("--open/--no-open", "opens", default=True, help="Open the page in a browser.")
def live(scenario: str | None, rotor: str | None, output: Path, only: bool, docs: str, opens: bool) -> None:
    """Write and open a page that runs a scenario live.

    The page runs the FMUs in a browser, where you can push the rotor. It works without a network.
    """
    from amb_cosim.presentation.plain_console import plain_console
    from amb_live.choice import rigs_of
    from amb_live.page import write_page

    with refusing():
        check_writable(output, is_folder=False)
        with plain_console(stderr=True).status("compiling the models for the browser, unless cached"):
            write_page(rigs_of(scenario, rotor, alone=only), output, docs)
    click.echo(f"live rig in {output}")
    if opens:
        click.launch(str(output.resolve()))


main.add_section("Run", live)
main.add_examples({"live": ("live drop", "live pump/levitation.toml -o pump.html")})
