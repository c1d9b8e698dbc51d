"""Errors of commands: one message, exit code 2 for bad input and 1 for a run that failed."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
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
    """Turn errors in the input, of an FMU that refuses to start, and of writing into `Refused`."""
    try:
        yield
    except (ValueError, StartFailed, FmuError) as error:
        raise Refused(str(error)) from error
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        raise Refused(f"{where}{error.strerror or error}") from error


def check_writable(path: Path, is_folder: bool) -> None:
    """Check before anything runs that results can be written, and leave nothing behind."""
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
