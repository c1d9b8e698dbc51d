"""The command that checks an FMU against its reference results."""

from __future__ import annotations

from pathlib import Path

import click

from amb_cosim.commands.cli_errors import refusing


@click.command()
@click.argument("fmu", type=click.Path(path_type=Path))
@click.pass_context
def verify(ctx: click.Context, fmu: Path) -> None:
    """Check an FMU against its reference results.

    FMPy runs the experiments in the FMU (FMI-LS-REF).

    The exit code is 1 if a value differs, or an experiment cannot be run.
    """
    from amb_cosim.cosim.verify.verification import verify

    with refusing():
        result = verify(fmu)
    for item in result:
        click.echo(item)
    if not all(item.is_equal for item in result):
        ctx.exit(1)


COMMANDS = (verify,)
