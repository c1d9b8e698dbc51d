"""The command line `amb-cosim`."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import click

from amb_cosim.commands import cache, compare, controller, fmus, listing, plot, rotor, run
from amb_cosim.commands.cli_errors import Refused, interrupted
from amb_cosim.commands.packs import PackCommands
from amb_cosim.cosim.errors import ModelWarning
from amb_cosim.cosim.processes.interruption import interruptible, was_interrupted
from amb_cosim.presentation.printable import printable_streams
from amb_files.packs import endless_distributions, unreadable_distributions

FORMER = {"animate": "live SCENARIO", "modes": "study modes"}  # commands of 0.2.0


class Commands(PackCommands):
    """Commands that end with a message and an exit code on Ctrl-C and SIGTERM."""

    def main(self, *args: Any, **options: Any) -> Any:
        """Run a command so that the text that it prints cannot control the terminal."""
        with printable_streams(), warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)  # commands print the sentences themselves
            return super().main(*args, **options)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Refuse arguments that are not UTF-8, because results, pages and figures contain file names as text."""
        for argument in args:
            if argument != argument.encode("utf-8", "replace").decode():
                raise Refused(f"argument {argument!r} is not UTF-8; rename the file or folder")
        _refuse(endless_distributions())
        try:
            return super().parse_args(ctx, args)
        except KeyboardInterrupt as error:  # while help imports the modules of packs
            raise interrupted("interrupted") from error

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
                _refuse(unreadable_distributions(), error)
            raise


def _refuse(distributions: Mapping[str, str], error: Exception | None = None) -> None:
    """Refuse an installed distribution with unreadable entry points, because Pydantic and xarray read them all."""
    for name, reason in distributions.items():
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
main.epilog = "\b\nExamples:\n  amb-cosim run drop\n  amb-cosim list --filter friction"
main.add_examples(
    {
        "run": ("run drop", "run drop --until 0.5 --set 'rotor_contact.*.mu=0.1'"),
        "simulate": ("simulate my_system.toml", "simulate plant.ssp --until 0.3 --step 1ms"),
        "compare": ("compare results/before results/after", "compare drop drop --set '2:rotor_contact.*.mu=0.1'"),
        "plot": ("plot results/drop '*.f_n' --until 0.3", "plot results/drop '*.f_n' -o drop.csv"),
        "list": ("list --filter 'base shock'", "list drop"),
        "rotor": ("rotor show pump/rotor.toml", "rotor import ross_rotor.toml"),
        "rotor import": ("rotor import ross_rotor.toml", "rotor import ross_rotor.toml --frequency '100 Hz'"),
        "controller": ("controller show pump/controller.toml", "controller import law.mat --sample-time 100us"),
        "controller import": ("controller import law.mat", "controller import law.npz --sample-time 100us"),
        "build": ("build -o fmus --rotor pump/rotor.toml", "build -o fmus --scenario drop --fmi 3"),
        "export-ssp": ("export-ssp drop -o drop.ssp", "export-ssp pump/levitation.toml -o pump.ssp"),
        "verify": ("verify plant.fmu", "verify fmus/amb_actuator.fmu"),
        "cache": ("cache", "cache --clear"),
    }
)
