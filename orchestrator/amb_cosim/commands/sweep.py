"""The command that runs a scenario over a grid or a sample of its values."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import click

from amb_cosim.commands.cli_errors import Failed, interrupted, refusing
from amb_cosim.commands.options import FLAVOUR, NO_PLOTS, RECEPTANCES, ROTOR, SETTINGS, UNITS, UNTIL, output
from amb_files.atomic import check_writable

VARY = """Values of a variable, NAME=START:STOP:COUNT or NAME=VALUE,VALUE,...; units are understood. What an event sets
begins with the label of an event; names joined by & are varied together; NAME=@FILE has a table of settings a label."""

ADAPTIVE = """Run only the points that are needed to know maximum:METRIC, minimum:METRIC or boundary:METRIC=LEVEL
to --certainty; boundary:recovered, contact or rolling bisects a grid."""


@click.command()
@click.argument("name")
@click.option("--vary", "vary", multiple=True, metavar="NAME=VALUES", help=VARY)
@click.option("--sample", metavar="lhs:N|sobol:N|saltelli:N", help="Draw N points of the ranges without a count.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of the sample.")
@SETTINGS
@output("Folder; default results/sweep_NAME.")
@UNTIL
@ROTOR
@RECEPTANCES
@FLAVOUR
@click.option(
    "--metric", "metrics", multiple=True, metavar="FILE:FUNCTION", help="A function of a result: numbers by name."
)
@click.option(
    "--keep", multiple=True, metavar="OUTCOME", help="Keep full records of runs that end so: trapped, failed, ...; all."
)
@click.option("--boundary", metavar="METRIC", help="Whose boundary maps draw: recovered (default), contact, rolling.")
@click.option("--adaptive", metavar="GOAL", help=ADAPTIVE)
@click.option("--certainty", type=float, metavar="SHARE", help="Of the range of values or an axis; 0.01 by default.")
@click.option(
    "--scheduler", metavar="ADDRESS", help="Of a Dask scheduler, such as tcp://host:8786, in place of processes here."
)
@click.option("--jobs", type=int, help="Number of processes here; one a processor by default.")
@NO_PLOTS
@UNITS
def sweep(name: str, vary: tuple[str, ...], output: Path | None, no_plots: bool, **options: Any) -> None:
    """Run a scenario over a grid or a sample of values.

    What runs lead to is in OUTPUT/sweep.zarr as soon as they end, and the same command goes on with a sweep that was
    ended. In place of a scenario NAME may be a ready sweep, such as `amb-cosim list` shows; options go over what it
    has.
    """
    folder = output or Path("results") / f"sweep_{Path(name).stem}"
    with refusing():
        check_writable(folder, is_folder=True)
        from amb_cosim.sweeps.axes import parse_vary

        options["metrics"] = [_function(text) for text in options["metrics"]]
        scenario, merged = _request(name, options | {"vary": parse_vary(vary)})
        from amb_cosim.sweeps.engine import ClusterFailed
        from amb_cosim.sweeps.outcomes import BROKEN_OFF
        from amb_cosim.sweeps.run import sweep as run_sweep

        try:
            swept = run_sweep(scenario, output=folder, **merged)
        except KeyboardInterrupt as error:
            raise interrupted(f"interrupted; the same command goes on with what is in {folder}") from error
        except ClusterFailed as error:
            raise Failed(f"{error}; the same command goes on with what is in {folder}") from error
        if not no_plots:
            from amb_cosim.sweeps.figures import draw_sweep

            draw_sweep(swept)
    click.echo(swept.summary)
    click.echo(f"results in {folder}")
    if not {*swept.outcomes} - {*BROKEN_OFF, ""}:
        raise Failed(f"no run of the sweep succeeded; reasons are above and in {folder}")


def _request(name: str, given: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return scenario and options of `amb_cosim.sweep`, those of a ready sweep under what is given."""
    from amb_cosim.sweeps.ready import named_sweeps

    ready = named_sweeps().get(name)
    merged = {} if ready is None else ready.options
    for key, value in given.items():
        if isinstance(value, Mapping):
            merged[key] = {**merged.get(key, {}), **value}
        elif value is not None:
            merged[key] = value
    return (name if ready is None else ready.scenario), merged


def _function(text: str) -> Callable[..., Any]:
    """Return the function that FILE:FUNCTION names; workers get it by value."""
    file, _, name = text.rpartition(":")
    if not file or not Path(file).is_file():
        raise ValueError(f"--metric {text} is not allowed; it must be FILE:FUNCTION, and FILE must exist")
    spec = importlib.util.spec_from_file_location(f"amb_cosim_metric_{Path(file).stem}", file)  # no package's name
    if spec is None or spec.loader is None:
        raise ValueError(f"--metric {text}: {file} is no Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
        function = getattr(module, name)
    except (Exception, SystemExit) as error:  # whatever the user's file raises
        raise ValueError(f"--metric {text}: {type(error).__name__}: {error}") from error
    import sys

    import cloudpickle

    sys.modules[module.__name__] = module
    cloudpickle.register_pickle_by_value(module)
    return function


COMMANDS = (sweep,)
