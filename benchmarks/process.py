"""Run functions in separate Python processes, if necessary by another Python that has the package they need."""

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

REPOSITORY = Path(__file__).parents[1]

# One thread for each candidate: more do not speed up matrices of this size.
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}

_CALL = """
import json, pathlib, runpy, sys
arguments, answer = map(pathlib.Path, sys.argv[3:])
result = runpy.run_path(sys.argv[1])[sys.argv[2]](**json.loads(arguments.read_text(encoding="utf-8")))
answer.write_text(json.dumps(result), encoding="utf-8")
"""


class CandidateFailed(RuntimeError):
    """A candidate failed or took too long; the message holds the last line of its output."""


@cache
def find_python_with(module: str) -> str | None:
    """Return the first Python that has `module`: this one, then each `python3` on the PATH; None if none has it."""
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


def run_function(python: str, file: str, function: str, timeout: float = 600.0, **arguments: Any) -> Any:
    """Run a function of a file with `python`, in an empty folder, and return its result.

    Arguments and result must fit into JSON. The file can import only what that Python has installed, which need not
    include this project.

    Raises
    ------
    CandidateFailed
        If it fails or takes longer than `timeout` (s).
    """
    with tempfile.TemporaryDirectory(prefix="benchmark-") as temporary:
        folder = Path(temporary)
        argument_file, answer = folder / "arguments.json", folder / "answer.json"
        argument_file.write_text(json.dumps(arguments), encoding="utf-8")
        command = [python, "-c", _CALL, file, function, str(argument_file), str(answer)]
        paths = [str(REPOSITORY), *filter(None, [os.environ.get("PYTHONPATH")])]
        environment = {**ENVIRONMENT, "TMPDIR": temporary, "PYTHONPATH": os.pathsep.join(paths)}
        try:
            process = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise CandidateFailed(f"{function} took longer than {timeout:g} s") from error
        if process.returncode != 0 or not answer.is_file():
            last = (process.stderr.strip() or process.stdout.strip()).splitlines()[-1:]
            raise CandidateFailed(f"{function} ended with {process.returncode}: {' '.join(last)}")
        return json.loads(answer.read_text(encoding="utf-8"))
