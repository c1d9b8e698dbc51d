"""Commands that run scenarios and systems."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from amb_cosim.commands.cli_errors import raise_failure, refuse_empty_record, refusing
from amb_cosim.commands.options import (
    ALL,
    FLAVOUR,
    ISOLATED,
    LOOP,
    NO_PLOTS,
    RECEPTANCES,
    ROTOR,
    SETTINGS,
    UNITS,
    UNTIL,
    output,
    results_of,
)
from amb_cosim.cosim.errors import computed_by
from amb_files.atomic import check_writable, plain_file, write_file

if TYPE_CHECKING:
    from amb_cosim.results.result import Result

FOLDER = output("Folder for the results; default: results/NAME, or results/FOLDER_NAME for a file FOLDER/NAME.toml.")
AUTOSAVE = """Time between automatic checkpoints; 0 disables them."""
AUTOSAVED = "autosave.npz"
STEP = click.option("--step", metavar="TIME", help="Communication step, such as 1ms, of an SSP archive without one.")


@click.command()
@click.argument("name")
@SETTINGS
@FOLDER
@UNTIL
@STEP
@ROTOR
@RECEPTANCES
@FLAVOUR
@LOOP
@ISOLATED
@NO_PLOTS
@UNITS
@ALL
@click.option("--save-at", multiple=True, metavar="MOMENT", help="Save the state at a time, such as 'cycle 5'.")
@click.option("--from", "start", metavar="FILE", help="Continue from a state saved by --save-at.")
@click.option(
    "--autosave", type=click.FloatRange(0.0), default=60.0, show_default=True, metavar="SECONDS", help=AUTOSAVE
)
@click.option("--summary-json", metavar="FILE", help="Also write the summary to FILE; - is standard output.")
def run(
    name: str,
    output: Path | None,
    step: str | None,
    no_plots: bool,
    show_all: bool,
    summary_json: str | None,
    autosave: float,
    **options: Any,
) -> None:
    """Run a scenario, its TOML file or an SSP archive."""
    if Path(name).suffix == ".ssp":
        fixed = {f"--{option}": options.pop(option) for option in ("rotor", "receptances")}
        fixed |= {"--save-at": options.pop("save_at") or None, "--from": options.pop("start")}
        values = fixed | {"--summary-json": summary_json}
        with refusing():
            unused = [option for option, value in values.items() if value is not None]
            if unused:
                raise ValueError(f"{' and '.join(unused)} cannot be used with an SSP archive, which contains its FMUs")
        _simulate(Path(name), output, show_all, step=step, **options)
        return
    from amb_cosim.presentation.plain_console import plain_console
    from amb_cosim.presentation.text_tables import show_notices
    from amb_cosim.results.plots import MODULES, draw_all
    from amb_cosim.results.result import RESULT, SUMMARY
    from amb_cosim.results.summary_table import print_summary
    from amb_cosim.scenario import simulation

    folder = output or results_of(name)
    summary_file = Path(summary_json) if summary_json not in (None, "-") else None
    with refusing():
        if step is not None:
            raise ValueError("--step is for SSP archives; set communication_step in the scenario")
        check_writable(folder, is_folder=True, files=(RESULT, SUMMARY, AUTOSAVED, *(f"{name}.png" for name in MODULES)))
        if summary_file is not None:
            check_writable(summary_file, is_folder=False)
        file = plain_file(folder, AUTOSAVED)
        options["autosave"] = file if autosave else None
        result = computed_by(simulation.run, name, **options, autosave_every=autosave)
        refuse_empty_record(result.outcome)
        text = result.summary.to_json()
        result.save(folder, plots=False)
        saved = [_save(result, moment, folder) for moment in options["save_at"]]
        if result.outcome.status != "interrupted":
            file.unlink(missing_ok=True)
        if summary_file is not None:
            write_file(summary_file, text)
    if summary_json == "-":
        click.echo(text, nl=False)
    console = plain_console(stderr=summary_json == "-")
    print_summary(result.summary, console, show_all)
    show_notices(result.summary.notices)
    for line in saved:
        console.print(line)
    if not no_plots:  # last, so that no fault of a figure hides the verdict
        with refusing():
            draw_all(result.signals, folder)
    console.print(f"results in {folder}")
    raise_failure(result.outcome, folder)


def _save(result: Result, moment: str, folder: Path) -> str:
    """Write the state of a run at a moment into a folder; return a text that names the file or explains its absence."""
    from amb_cosim.results.result import checkpoint_name

    try:
        state, file = result.checkpoint(moment), plain_file(folder, checkpoint_name(moment))
        state.save(file)
        if (by_time := folder / checkpoint_name(f"{state.time:.9g} s")) != file:
            by_time.unlink(missing_ok=True)  # of `Result.save`
    except ValueError as error:
        return str(error)
    return f"state at {moment} saved in {file}"


@click.command()
@click.argument("system_file", type=click.Path(path_type=Path))
@SETTINGS
@FOLDER
@click.option("--until", metavar="TIME", help="End time for an SSP archive, such as 0.3 (s) or 300ms.")
@STEP
@ROTOR
@FLAVOUR
@LOOP
@ISOLATED
@ALL
def simulate(system_file: Path, output: Path | None, show_all: bool, **options: Any) -> None:
    """Run the FMUs of a system file or an SSP archive.

    Any co-simulation FMUs of FMI 2.0 and 3.0 are supported.
    """
    _simulate(system_file, output, show_all, **options)


def _simulate(
    system_file: Path, output: Path | None, show_all: bool, step: str | None, until: str | None, **options: Any
) -> None:
    """Run a system file or an SSP archive, save the record, and print the outcome."""
    from amb_cosim.cosim.record.warnings import sentences, warnings_of
    from amb_cosim.cosim.run import simulate as simulation
    from amb_cosim.cosim.system.tables import time_of
    from amb_cosim.cosim.system.values import quantity
    from amb_cosim.presentation.text_tables import show_notices, show_warnings

    folder = output or results_of(system_file)
    with refusing():
        if system_file.suffix != ".ssp" and (step, until) != (None, None):
            raise ValueError("--step and --until are for SSP archives; set them in the system file's experiment")
        options["step_size"] = None if step is None else time_of(step, "--step")
        options["stop_time"] = None if until is None else quantity(until, "s", "--until")
        check_writable(folder, is_folder=True, files=("result.nc",))
        result = computed_by(simulation.simulate, system_file, **options)
        refuse_empty_record(result.outcome)
        result.save(folder)
    show_warnings(sentences(warnings_of(result.signals)), whole=show_all)
    show_notices(json.loads(result.signals.attrs["notices"]))
    click.echo(f"{result.outcome}; results in {folder}")
    raise_failure(result.outcome, folder)


COMMANDS = (run, simulate)
