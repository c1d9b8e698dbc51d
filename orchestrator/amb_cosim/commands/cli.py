"""The command line `amb-cosim`."""

from __future__ import annotations

from typing import Any

import click

from amb_cosim.commands import cache, compare, controller, fmus, listing, plot, rotor, run
from amb_cosim.commands.cli_errors import Refused, interrupted
from amb_cosim.commands.packs import PackCommands
from amb_cosim.cosim.basics.interruption import interruptible, was_interrupted
from amb_cosim.presentation.printable import printable_streams

FORMER = {"animate": "live SCENARIO", "modes": "study modes"}  # commands of 0.2.0


class Commands(PackCommands):
    """Commands that end with a message and an exit code on Ctrl-C and SIGTERM."""

    def main(self, *args: Any, **options: Any) -> Any:
        """Run a command whose texts cannot control the terminal."""
        with printable_streams():
            return super().main(*args, **options)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse arguments that are not UTF-8: results, pages and figures contain file names as text."""
        for argument in args:
            if argument != argument.encode("utf-8", "replace").decode():
                raise Refused(f"argument {argument!r} is not UTF-8; rename the file or folder")
        return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            with interruptible():
                return super().invoke(ctx)
        except KeyboardInterrupt as error:
            raise interrupted("interrupted") from error
        except Exception as error:  # an import interrupted by a signal may fail with any error
            if was_interrupted():
                raise interrupted(getattr(error, "message", "interrupted")) from error
            is_message = isinstance(error, click.ClickException | click.exceptions.Exit | click.Abort)
            if not is_message or isinstance(error.__cause__, UnicodeDecodeError):
                _check_distributions(error)
            raise


def _check_distributions(error: Exception) -> None:
    """Refuse an installed distribution whose entry points cannot be read: Pydantic and xarray read all of them."""
    from amb_files.packs import unreadable_distributions

    for name, reason in unreadable_distributions().items():
        problem = f"entry_points.txt of the installed {name} cannot be read: {reason}"
        raise Refused(f"{problem}; correct or uninstall it") from error


@click.group(cls=Commands, former=FORMER, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="amb-cosim")
def main() -> None:
    """Co-simulation of a flexible rotor in magnetic bearings that can touch its retainer bearings."""


main.add_section("Run", *run.COMMANDS, *compare.COMMANDS, *plot.COMMANDS, *listing.COMMANDS)
main.add_section("Design and judge", *rotor.COMMANDS, *controller.COMMANDS)
main.add_section("FMUs and other tools", *fmus.COMMANDS)
main.add_section("Housekeeping", *cache.COMMANDS)
