"""Commands that run scenarios and list them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.table import Table

from amb_cosim.commands.cli_errors import Failed, check_writable, refusing
from amb_cosim.commands.options import FLAVOUR, RECEPTANCES, ROTOR, SETTINGS
from amb_cosim.commands.progress import simulating
from amb_cosim.cosim.master import LOOPS, Loop
from amb_cosim.flavours import Flavour
from amb_cosim.scenario import load_scenario, packaged_scenarios


@click.command()
@click.argument("name")
@SETTINGS
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for the results; default results/NAME.")
@click.option("--until", type=float, metavar="SECONDS", help="End of the run, from the beginning of cycle 0.")
@ROTOR
@RECEPTANCES
@FLAVOUR
@click.option(
    "--loop",
    type=click.Choice(LOOPS),
    default="compiled",
    show_default=True,
    help="What calls the FMUs step by step: machine code, or Python, for reference.",
)
@click.option("--no-plots", is_flag=True, help="Draw no figures.")
@click.option("--summary-json", metavar="FILE", help="Also write the summary to FILE; - is standard output.")
def run(
    name: str,
    settings: tuple[str, ...],
    output: Path | None,
    until: float | None,
    rotor_file: Path | None,
    receptances: Path | None,
    flavour: Flavour,
    loop: Loop,
    no_plots: bool,
    summary_json: str | None,
) -> None:
    """Run the scenario NAME, or the one in a TOML file."""
    from amb_cosim import plots, results, simulation
    from amb_cosim.plan import parse_settings
    from fmi_export.files import write_atomically

    folder = output or Path("results") / Path(name).stem
    copy = Path(summary_json) if summary_json not in (None, "-") else None
    console = Console(stderr=True)
    with refusing():
        files = {"rotor": rotor_file, "receptances": receptances}
        given = {key: str(file) for key, file in files.items() if file is not None}
        scenario = load_scenario(name).model_copy(update=given)
        check_writable(folder, is_folder=True)
        if copy is not None:
            check_writable(copy, is_folder=False)
        with console.status("preparing the FMUs"):
            prepared = simulation.prepare(Path(name).stem, scenario, parse_settings(settings), until, flavour)
        with simulating(console) as report:
            outcome = simulation.run(prepared, report, loop)

    figures = results.summary(outcome.dataset)
    text = json.dumps(figures, indent=2, allow_nan=False) + "\n"
    with refusing():
        folder.mkdir(parents=True, exist_ok=True)
        results.save(outcome.dataset, folder / "result.nc")
        for path in [folder / "summary.json"] + ([copy] if copy is not None else []):
            write_atomically(path, lambda p: p.write_text(text, encoding="utf-8"))
        if not no_plots:
            plots.draw_all(outcome.dataset, folder)
    if summary_json == "-":
        click.echo(text, nl=False)
    _show(Console(stderr=summary_json == "-"), figures, folder)
    if outcome.failure is not None:
        raise Failed(f"{outcome.failure}; what was recorded until then is in {folder}")


@click.command("list")
def list_scenarios() -> None:
    """List the scenarios."""
    table = Table(box=None, pad_edge=False)
    for column in ("name", "description", "source"):
        table.add_column(column, no_wrap=column == "name")
    for name in packaged_scenarios():
        scenario = load_scenario(name)
        table.add_row(name, scenario.description, scenario.source)
    Console().print(table)


def _show(console: Console, figures: dict[str, Any], folder: Path) -> None:
    table = Table(title=figures["scenario"], show_header=False, title_justify="left")
    shares = ", ".join(
        f"{name} {100 * share:.1f} %"
        for name, share in zip(("none", "RB1", "RB2", "both"), figures["contact_share"].values(), strict=True)
        if share is not None
    )
    for label, key, unit in (
        ("peak contact force", "peak_contact_force_N", "N"),
        ("peak impulse", "peak_impulse_Ns", "N s"),
        ("orbit before the step", "orbit_before_mm", "mm"),
        ("orbit at the end", "orbit_after_mm", "mm"),
        ("largest orbit", "orbit_largest_mm", "mm"),
    ):
        table.add_row(label, _at_places(figures[key], unit))
    for label, when in (("before the change", "before"), ("at the end", "end")):
        table.add_row(f"synchronous part {label}", _at_places(figures["settled_amplitude_mm"][when], "mm"))
    table.add_row("contact between step and removal", shares or "-")
    first, last = (figures[key] for key in ("first_contact_cycle", "last_contact_cycle"))
    table.add_row("contact", "none" if first is None else f"from cycle {first:.4g} to {last:.4g}")
    if figures["outcome"] is not None:
        table.add_row("outcome", figures["outcome"])
    else:
        table.add_row("recovered", {True: "yes", False: "no", None: "-"}[figures["recovered"]])
    if figures["rolling_from_cycle"] is not None:
        whirls = ", ".join(f"{at.upper()} {_number(w)} rad/s" for at, w in figures["whirl_speed_rad_s"].items())
        table.add_row("rolling", f"from cycle {figures['rolling_from_cycle']:.4g}; whirl at the end {whirls}")
    table.add_row(
        "simulated", f"{figures['simulated_s']:.4g} s, {_number(figures['real_time_factor'])} times real time"
    )
    if figures["stopped"] is not None:
        table.add_row("stopped", figures["stopped"])
    console.print(table)
    console.print(f"results in {folder}")


def _at_places(values: dict[str, float | None], unit: str) -> str:
    return ", ".join(f"{at.upper()} {_number(value)} {unit}" for at, value in values.items())


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


COMMANDS = (run, list_scenarios)
