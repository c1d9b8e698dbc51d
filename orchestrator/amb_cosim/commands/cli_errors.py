"""Errors of commands: one message, exit code 2 for bad input and 1 for what failed on the way."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any

import click

from amb_cosim.cosim.errors import FmuError, StartFailed


class Failed(click.ClickException):
    """Something went wrong on the way: one message and exit code 1."""

    exit_code = 1

    def show(self, file: IO[Any] | None = None) -> None:
        for line in self.message.splitlines():
            click.echo(f"amb-cosim: {line}", err=True)


class Refused(Failed):
    """Bad input: one message and exit code 2."""

    exit_code = 2


@contextmanager
def refusing() -> Iterator[None]:
    """Turn errors in the input and of an FMU that refuses to start into `Refused`, those of writing into `Failed`."""
    try:
        yield
    except (ValueError, StartFailed, FmuError) as error:
        raise Refused(str(error)) from error
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        raise Failed(f"{where}{error.strerror or error}") from error
