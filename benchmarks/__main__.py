"""`python -m benchmarks`: measure cost, as ratios within one run."""

from __future__ import annotations

from pathlib import Path

import click
from rich.console import Console

from amb_cosim.commands.cli_errors import refusing
from amb_cosim.commands.options import JSON
from amb_cosim.commands.printing import show
from amb_files.atomic import check_writable


@click.group(invoke_without_command=True)
@JSON
@click.option("--quick", is_flag=True, help="Short runs, once each: shows that it works, the numbers mean little.")
@click.pass_context
def main(context: click.Context, as_json: bool, quick: bool) -> None:
    """Measure cost, as ratios within one run: against a loop without FMI, other masters, ROSS, Siconos."""
    if context.invoked_subcommand is not None:
        return
    from benchmarks.measure import FULL, QUICK, measure
    from benchmarks.report import as_tables

    with refusing(), Console(stderr=True).status("") as status:
        data = measure(QUICK if quick else FULL, status.update)
    show(data, as_tables, as_json)


@main.command()
@JSON
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Also draw the comparison, into this folder.")
def contact(as_json: bool, output: Path | None) -> None:
    """Compare contact as a constraint with the classical stiff laws, at equal accuracy."""
    from benchmarks import contact_cost

    with refusing():
        if output is not None:
            check_writable(output, is_folder=True)
        with Console(stderr=True).status("measuring (the first run compiles the models)"):
            data = contact_cost.compare()
        if output is not None:
            output.mkdir(parents=True, exist_ok=True)
            contact_cost.draw(data, output / "contact_cost.png")
    show(data, contact_cost.as_tables, as_json)


@main.command()
@JSON
@click.option("--quick", is_flag=True, help="A short run: shows that it works, the numbers mean little.")
def live(as_json: bool, quick: bool) -> None:
    """Compare WebAssembly in node and in Chromium with native FMUs."""
    from benchmarks.live import measure

    with refusing(), Console(stderr=True).status("measuring (the first run compiles the models)"):
        data = measure.measure({"fig4_9": 0.1}, rounds=1) if quick else measure.measure()
    show(data, measure.as_tables, as_json)


@main.command()
@JSON
@click.option("--quick", is_flag=True, help="A few runs: shows that it works, the numbers mean little.")
def sweep(as_json: bool, quick: bool) -> None:
    """Measure sweeps: overhead of a run, one and two processes, FMPy in a loop, memory over 5,000 runs."""
    from benchmarks import sweeps

    with refusing(), Console(stderr=True).status("") as status:
        data = sweeps.measure(sweeps.QUICK if quick else sweeps.SweepEffort(), status.update)
    show(data, sweeps.as_tables, as_json)


@main.command()
@click.argument("scenarios", nargs=-1)
@JSON
@click.option("--rounds", type=click.IntRange(min=1), default=3, help="How often each scenario runs.")
def steps(scenarios: tuple[str, ...], as_json: bool, rounds: int) -> None:
    """Measure the longest step of SCENARIOS, by default of all."""
    from benchmarks import step_times

    with refusing(), Console(stderr=True).status("measuring (the first run compiles the models)"):
        data = step_times.measure(scenarios, rounds)
    show(data, step_times.as_tables, as_json)


if __name__ == "__main__":
    main(prog_name="python -m benchmarks")
