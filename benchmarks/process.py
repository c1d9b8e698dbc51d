"""Runs functions in Python processes of their own, also where another Python has the package that they need."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

# One thread for each candidate: matrices of this size are no faster with more.
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}

_CALL = """
import json, pathlib, runpy, sys
given, answer = map(pathlib.Path, sys.argv[3:])
found = runpy.run_path(sys.argv[1])[sys.argv[2]](**json.loads(given.read_text(encoding="utf-8")))
answer.write_text(json.dumps(found), encoding="utf-8")
"""


class Unfinished(RuntimeError):
    """A process did not come to its end; the message is what it said last."""


@cache
def python_with(module: str) -> str | None:
    """The first Python that has `module`: this one, then each `python3` on the PATH; None if none can."""
    return next((python for python in _pythons() if _has(python, module)), None)


def _pythons() -> Iterator[str]:
    yield sys.executable
    for folder in os.get_exec_path():
        python = Path(folder) / "python3"
        if python.is_file() and os.access(python, os.X_OK):
            yield str(python)


def _has(python: str, module: str) -> bool:
    probe = f"import importlib.util, sys; sys.exit(importlib.util.find_spec({module!r}) is None)"
    try:
        command = [python, "-I", "-c", probe]
        return subprocess.run(command, capture_output=True, timeout=120, check=False).returncode == 0
    except (OSError, subprocess.SubprocessError):
        return False


def call(python: str, file: str, function: str, timeout: float = 600.0, **arguments: Any) -> Any:
    """What a function of a file returns that is run by `python`, in an empty folder.

    Arguments and result are what JSON can hold. The file imports what that Python has, and need not know of this
    project.

    Raises
    ------
    Unfinished
        If it fails or takes longer than `timeout` (s).
    """
    with tempfile.TemporaryDirectory(prefix="bench-") as temporary:
        folder = Path(temporary)
        given, answer = folder / "given.json", folder / "answer.json"
        given.write_text(json.dumps(arguments), encoding="utf-8")
        command = [python, "-c", _CALL, file, function, str(given), str(answer)]
        environment = {**ENVIRONMENT, "TMPDIR": temporary}
        try:
            process = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise Unfinished(f"{function} took longer than {timeout:g} s") from error
        if process.returncode != 0 or not answer.is_file():
            last = (process.stderr.strip() or process.stdout.strip()).splitlines()[-1:]
            raise Unfinished(f"{function} ended with {process.returncode}: {' '.join(last)}")
        return json.loads(answer.read_text(encoding="utf-8"))
