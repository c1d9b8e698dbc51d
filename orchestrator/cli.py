"""Command line: run scenarios, list them, build the FMUs, print the thesis's tables."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from orchestrator.component import FmuError
from orchestrator.master import StartFailed
from orchestrator.scenario import load_scenario, packaged_scenarios

BAD_INPUT, FAILED = 2, 1

F = TypeVar("F", bound=Callable[..., Any])


def _fail(message: str, code: int) -> NoReturn:
    for line in message.splitlines():
        click.echo(f"amb-cosim: {line}", err=True)
    sys.exit(code)


def _explained(command: F) -> F:
    """Bad input and an FMU that refuses to start end a command with one message and exit code 2."""

    @wraps(command)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        try:
            return command(*args, **kwargs)
        except (ValueError, StartFailed, FmuError) as error:
            _fail(str(error), BAD_INPUT)
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            _fail(f"{where}{error.strerror or error}", BAD_INPUT)

    return wrapper  # type: ignore[return-value]


@click.group()
@click.version_option(package_name="amb-cosim")
def main() -> None:
    """Co-simulation of a flexible rotor in magnetic bearings that can touch its retainer bearings."""


@main.command()
@click.argument("name")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="COMPONENT.VARIABLE=VALUE",
    help="Replace a value; units are understood.",
)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Folder for the results; default results/NAME.")
@click.option("--until", type=float, metavar="SECONDS", help="End of the run, from the beginning of cycle 0.")
@click.option("--no-plots", is_flag=True, help="Draw no figures.")
@click.option("--summary-json", metavar="FILE", help="Also write the summary to FILE; - is standard output.")
@_explained
def run(
    name: str,
    settings: tuple[str, ...],
    output: Path | None,
    until: float | None,
    no_plots: bool,
    summary_json: str | None,
) -> None:
    """Run the scenario NAME, or the one in a TOML file."""
    from orchestrator import plots, results, simulation
    from orchestrator.plan import parse_settings

    folder = output or Path("results") / Path(name).stem
    scenario = load_scenario(name)
    _check_writable(folder, is_folder=True)
    if summary_json not in (None, "-"):
        _check_writable(Path(summary_json), is_folder=False)
    console = Console(stderr=True)
    with console.status("preparing the FMUs"):
        prepared = simulation.prepare(Path(name).stem, scenario, parse_settings(settings), until)
    with _progress(console) as report:
        outcome = simulation.run(prepared, report)

    figures = results.summary(outcome.dataset)
    text = json.dumps(figures, indent=2, allow_nan=False) + "\n"
    folder.mkdir(parents=True, exist_ok=True)
    results.save(outcome.dataset, folder / "result.nc")
    results.write_atomically(folder / "summary.json", lambda path: path.write_text(text, encoding="utf-8"))
    if not no_plots:
        plots.draw_all(outcome.dataset, folder)
    if summary_json == "-":
        click.echo(text, nl=False)
    elif summary_json is not None:
        results.write_atomically(Path(summary_json), lambda path: path.write_text(text, encoding="utf-8"))
    _show(Console(stderr=summary_json == "-"), figures, folder)
    if outcome.failure is not None:
        _fail(f"{outcome.failure}; what was recorded until then is in {folder}", FAILED)


@main.command("list")
@_explained
def list_scenarios() -> None:
    """List the scenarios."""
    table = Table(box=None, pad_edge=False)
    for column in ("name", "description", "source"):
        table.add_column(column, no_wrap=column == "name")
    for name in packaged_scenarios():
        scenario = load_scenario(name)
        table.add_row(name, scenario.description, scenario.source)
    Console().print(table)


@main.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("build"), show_default=True)
@_explained
def build(output: Path) -> None:
    """Build the FMUs into a folder."""
    from orchestrator.build import build_all

    _check_writable(output, is_folder=True)
    for path in build_all(output):
        click.echo(path)


@main.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@_explained
def tables(as_json: bool) -> None:
    """Print the thesis's tables 3.1 and 3.4 and the bearing constants, computed from the models."""
    from orchestrator.build import frequency_tables

    data = frequency_tables()
    if as_json:
        click.echo(json.dumps(data, indent=2))
        return
    console = Console()
    for title, rows in _table_rows(data).items():
        table = Table("", *(f"{i + 1}" for i in range(8)), title=f"{title}: damped natural frequencies (rad/s)")
        for label, frequencies in rows:
            table.add_row(label, *(f"{f:.2f}" for f in frequencies))
        console.print(table)
    console.print(f"K_s = {data['amb']['k_s'] / 1e3:.2f} N/mm, K_i = {data['amb']['k_i']:.2f} N/A (2.8, 2.9)")


def _table_rows(data: dict[str, Any]) -> dict[str, list[tuple[str, list[float]]]]:
    return {
        "Table 3.1": [
            (f"{model.replace('_', ' ')}s, {mass} mass, {speed} rad/s", frequencies)
            for model, masses in data["table_3_1"].items()
            for mass, speeds in masses.items()
            for speed, frequencies in speeds.items()
        ],
        "Table 3.4": [
            (f"{model.replace('_', ' ')}, {speed} rad/s", frequencies)
            for speed, models in data["table_3_4"].items()
            for model, frequencies in models.items()
        ],
    }


def _check_writable(path: Path, is_folder: bool) -> None:
    """Find out that results cannot be written before anything runs, and leave nothing behind."""
    if is_folder and path.exists() and not path.is_dir():
        raise ValueError(f"{path} cannot be written to; it is a file, and the output must be a folder")
    if not is_folder and path.is_dir():
        raise ValueError(f"{path} cannot be written to; it is a folder")
    parent = path if is_folder else path.parent
    if not is_folder and not parent.is_dir():
        raise ValueError(f"{path} cannot be written to; there is no folder {parent}")
    existing = next(p for p in (parent, *parent.absolute().parents) if p.exists())
    try:
        with tempfile.TemporaryDirectory(prefix=".", dir=existing):
            pass
    except OSError as error:
        raise ValueError(f"{path} cannot be written to: {os.strerror(error.errno or 0)} ({existing})") from error


@contextmanager
def _progress(console: Console) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error that appears with the first report."""
    columns = (TextColumn("simulating"), BarColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)


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
    ):
        values = (f"{at.upper()} {_number(value)} {unit}" for at, value in figures[key].items())
        table.add_row(label, ", ".join(values))
    table.add_row("contact between step and removal", shares or "-")
    first, last = (figures[key] for key in ("first_contact_cycle", "last_contact_cycle"))
    table.add_row("contact", "none" if first is None else f"from cycle {first:.4g} to {last:.4g}")
    table.add_row("recovered", {True: "yes", False: "no", None: "-"}[figures["recovered"]])
    table.add_row(
        "simulated", f"{figures['simulated_s']:.4g} s, {_number(figures['real_time_factor'])} times real time"
    )
    console.print(table)
    console.print(f"results in {folder}")


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
