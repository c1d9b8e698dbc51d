"""Errors of commands: one message, and exit code 2 for bad input, 1 for a failure, 130 or 143 for a signal."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import click

from amb_cosim.cosim.errors import FmuError, ProcessFailed, StartFailed
from amb_cosim.cosim.processes.interruption import was_terminated

if TYPE_CHECKING:
    from amb_cosim.cosim.run.recording import Outcome


LONGEST_BEGIN, LONGEST_END = 1500, 500  # characters of a line that has an arbitrary name of a file in it
LONGEST = LONGEST_BEGIN + LONGEST_END


class Failed(click.ClickException):
    """A failure: one message and exit code 1."""

    exit_code = 1

    def show(self, file: IO[Any] | None = None) -> None:
        for line in self.message.splitlines():
            is_long = len(line) > LONGEST
            shown = f"{line[:LONGEST_BEGIN]} ... {line[-LONGEST_END:]}" if is_long else line
            click.echo(f"amb-cosim: {shown}", err=True)


class Interrupted(Failed):
    """Ctrl-C: one message and exit code 130."""

    exit_code = 130


class Terminated(Failed):
    """SIGTERM: one message and exit code 143."""

    exit_code = 143


class Refused(Failed):
    """Bad input: one message and exit code 2."""

    exit_code = 2


@contextmanager
def refusing() -> Iterator[None]:
    """Raise `Refused` for invalid input and FMUs that refuse to start, and `Failed` for errors in writing.

    `Failed` is also raised if the process that runs the FMUs ends.
    """
    try:
        yield
    except (ValueError, StartFailed, FmuError) as error:
        raise Refused(with_options(str(error))) from error
    except ProcessFailed as error:
        raise Failed(str(error)) from error
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        raise Failed(f"{where}{error.strerror or error}") from error


def with_options(message: str) -> str:
    """Return a text of a function with the names of the command's options in place of those of its arguments.

    Errors and results state arguments as they are written in Python: `up_to = 3 is not allowed`, `up_to='50 Hz'`,
    `channels={'acc1': '0.1 m.x'}`, or the mere name in backticks.
    """
    context = click.get_current_context(silent=True)
    for parameter in () if context is None else context.command.params:
        if isinstance(parameter, click.Option) and parameter.name:
            option = max(parameter.opts, key=len)
            begin = rf"(?<![\w.`]){parameter.name}"
            message = re.sub(f"{begin} = ", f"{option.removeprefix('--')} = ", message)
            message = re.sub(rf"{begin}=\{{'(.*?)': '(.*?)'\}}", rf"{option} '\1=\2'", message)
            message = re.sub(rf"{begin}='(.*?)'", rf"{option} '\1'", message)
            message = message.replace(f"`{parameter.name}`", option)
    return message


def interrupted(message: str) -> Failed:
    """Return the error for a command that was ended by a signal."""
    return Terminated(message) if was_terminated() else Interrupted(message)


def refuse_empty_record(outcome: Outcome) -> None:
    """Raise an error if a run was interrupted before it recorded anything, so that no older result is overwritten."""
    if outcome.status == "interrupted" and outcome.time <= 0.0:
        raise interrupted("interrupted before anything was recorded; nothing was written")


def raise_failure(outcome: Outcome, folder: Path) -> None:
    """Raise an error with the cause if a run ended early."""
    if outcome.failure is not None:
        failed = interrupted if outcome.status == "interrupted" else Failed
        raise failed(f"{outcome.failure}; the record up to that time is in {folder}")
