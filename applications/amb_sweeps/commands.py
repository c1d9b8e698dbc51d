"""The commands that run a scenario many times: over a grid or a sample of its values, and for its robustness."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from amb_analysis.studies.commands.analysis import SCENARIO, add_study, study
from amb_cosim.commands.cli import main
from amb_cosim.commands.cli_errors import Failed, interrupted, refusing
from amb_cosim.commands.options import (
    FLAVOUR,
    NO_PLOTS,
    RECEPTANCES,
    ROTOR,
    SETTINGS,
    UNITS,
    UNTIL,
    former_option,
    output,
    results_of,
)
from amb_files.atomic import check_writable

if TYPE_CHECKING:
    from amb_sweeps.ready import NamedSweep


@click.command()
@click.argument("name")
@click.option(
    "--vary", "vary", multiple=True, metavar="NAME=VALUES", help="Values of a variable (see above); repeatable."
)
@click.option(
    "--sample",
    metavar="METHOD",
    help="random:N, lhs:N, sobol:N or saltelli:N for N points, or boundary:METRIC (see above).",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the sample.")
@SETTINGS
@output("Folder; default: results/sweep_NAME.")
@UNTIL
@ROTOR
@RECEPTANCES
@FLAVOUR
@click.option(
    "--metric",
    "metrics",
    multiple=True,
    metavar="FILE:FUNCTION",
    help="Function that returns named numbers of a result.",
)
@click.option(
    "--keep", multiple=True, metavar="OUTCOME", help="Outcomes of runs to save in full: trapped, failed, ...; or all."
)
@click.option("--boundary", metavar="METRIC", help="Boundary in maps: recovered (default), contact, rolling.")
@former_option("--refine", "--sample boundary:METRIC")
@click.option(
    "--certainty", type=float, metavar="SHARE", help="Boundary tolerance, as a share of an axis; default: 0.01."
)
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler to use, such as tcp://host:8786.")
@click.option("--jobs", type=int, help="Number of local processes; default: one per processor.")
@NO_PLOTS
@UNITS
def sweep(name: str, vary: tuple[str, ...], output: Path | None, no_plots: bool, **options: Any) -> None:
    """Run a scenario over a grid or a sample of values.

    Each result is in OUTPUT/sweep.zarr as soon as its run ends; the same command continues an interrupted sweep. NAME
    may also be a ready sweep listed by `amb-cosim list`; options override its settings.

    --vary takes NAME=START:STOP:COUNT, NAME=VALUE,VALUE,... with units, or NAME=@FILE for a table with one setting per
    label. Names joined by & vary together; variables that an event sets begin with the label of the event.

    --sample draws points from ranges NAME=START:STOP, from normal(MEAN, SD), lognormal(MEDIAN, CV), triangular(A, B, C)
    or rayleigh(MODE), each followed by `in START:STOP` to limit it, and from NAME=@FILE.csv with one value per line.

    --sample boundary:recovered, boundary:contact or boundary:rolling bisects between the points of a grid.
    """
    named = results_of(name)
    folder = output or named.with_name(f"sweep_{named.name}")
    with refusing():
        check_writable(folder, is_folder=True)
        from amb_sweeps.axes import parse_vary

        options["metrics"] = [_function(text) for text in options["metrics"]]
        scenario, description, merged = _request(name, options | {"vary": parse_vary(vary)})
        from amb_sweeps.engine import ClusterFailed
        from amb_sweeps.outcomes import BROKEN_OFF
        from amb_sweeps.run import sweep as run_sweep

        try:
            swept = run_sweep(scenario, output=folder, **merged)
        except KeyboardInterrupt as error:
            raise interrupted(f"interrupted; run the same command again to continue the sweep in {folder}") from error
        except ClusterFailed as error:
            raise Failed(f"{error}; run the same command again to continue the sweep in {folder}") from error
        if not no_plots:
            from amb_sweeps.figures import draw_sweep

            draw_sweep(replace(swept, description=description))
    click.echo(swept.summary)
    click.echo(f"results in {folder}")
    if not {*swept.outcomes} - {*BROKEN_OFF, ""}:
        raise Failed(f"no run of the sweep succeeded; reasons are above and in {folder}")


def _request(name: str, options: Mapping[str, Any]) -> tuple[str, str, dict[str, Any]]:
    """Return scenario, description and options of `amb_cosim.sweep`; `options` override those of a ready sweep.

    The description belongs to a ready sweep; for other sweeps it is empty.
    """
    from amb_files.packs import files_of
    from amb_sweeps.ready import read_sweep

    file = files_of("sweeps").get(name)
    ready = None if file is None else read_sweep(name, file)
    merged = {} if ready is None else ready.options
    if ready is not None:
        merged["vary"] = _kept(ready, options)
    for key, value in options.items():
        if isinstance(value, Mapping):
            merged[key] = {**merged.get(key, {}), **value}
        elif value is not None:
            merged[key] = value
    return (name, "", merged) if ready is None else (ready.scenario, ready.description, merged)


def _kept(ready: NamedSweep, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the variations of a ready sweep, without variations of variables that `options` vary."""
    from amb_cosim.cosim.run.options import RunOptions
    from amb_cosim.scenario.prepare_run import assemble_scenario
    from amb_cosim.scenario.scenario import as_scenario
    from amb_sweeps.overlaps import not_replaced

    if not options["vary"]:
        return ready.vary
    scenario = as_scenario(ready.scenario, options["rotor"], options["receptances"])
    assembly = assemble_scenario(scenario, options["set"], RunOptions(flavour=options["flavour"]))
    return not_replaced(ready.vary, options["vary"], scenario.labels, assembly.assignments())


def _function(text: str) -> Callable[..., Any]:
    """Return the function named by FILE:FUNCTION; it is pickled by value, so that workers do not import FILE."""
    file, _, name = text.rpartition(":")
    if not file or not Path(file).is_file():
        raise ValueError(f"--metric {text} is not allowed; it must be FILE:FUNCTION, and FILE must exist")
    unique = f"amb_cosim_metric_{Path(file).stem}"  # no package has this name
    spec = importlib.util.spec_from_file_location(unique, file)
    if spec is None or spec.loader is None:
        raise ValueError(f"--metric {text}: {file} is not a Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        function = getattr(module, name)
    except (Exception, SystemExit) as error:  # any error of the user's file
        raise ValueError(f"--metric {text}: {type(error).__name__}: {error}") from error
    import sys

    import cloudpickle

    sys.modules[module.__name__] = module
    cloudpickle.register_pickle_by_value(module)
    return function


main.add_section("Run", sweep)
add_study(
    "robustness",
    SCENARIO,
    ROTOR,
    SETTINGS,
    click.option("--change", type=float, default=0.01, show_default=True, help="Relative change of each quantity."),
    click.option("--friction", type=float, help="Relative change of friction; default: 0.2 in a landing, or --change."),
    click.option("--restitution", type=float, help="Change of restitution; default: 0.1 in a landing, or --change."),
    click.option("--phases", type=int, default=32, show_default=True, help="Number of phases of the disturbance."),
    FLAVOUR,
    shows_progress=True,
)
study.list_in_section("Checks of a result", "robustness")
main.add_examples(
    {
        "sweep": (
            "sweep drop --vary Omega='2000:3000 rpm:11'",
            "sweep drop --vary 'rotor_contact.*.mu=0.1:0.5:5'",
        )
    }
)
study.add_examples({"robustness": ("study robustness drop", "study robustness pump/landing.toml --change 0.02")})
