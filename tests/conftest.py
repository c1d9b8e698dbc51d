"""What all tests share: subprocesses, and FMUs built once."""

from __future__ import annotations

import inspect
import json
import os
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis
import pytest

# The search for counterexamples is random at a developer's desk and the same every time where a build depends on it.
# No deadlines: a first example may compile a kernel.
hypothesis.settings.register_profile("patient", deadline=None)
hypothesis.settings.register_profile("repeatable", deadline=None, derandomize=True)
hypothesis.settings.load_profile("patient")
if os.environ.get("CI"):
    hypothesis.settings.load_profile("repeatable")

SUPPORT = Path(__file__).parent / "fmi_export" / "support"  # modules that subprocesses can import
HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "support"), str(SUPPORT), str(HERE / "native" / "support")]  # cases, probes, tools


@pytest.fixture(scope="session")
def run_python(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """`run_python(what, timeout=60, cwd=None, **arguments)` in a Python process of its own.

    `what` is a function, which must import what it needs in its body and is called with `arguments`, or the text
    of a program. The function's return value, or what the program assigns to `result`, comes back through JSON
    (floats to the last bit).
    A process that fails, crashes on exit, or takes longer than `timeout` seconds fails the test with its output.
    """

    def run(what: Callable[..., Any] | str, timeout: float = 60.0, cwd: Path | None = None, **arguments: Any) -> Any:
        folder = tmp_path_factory.mktemp("process")
        answer = folder / "answer.json"
        if callable(what):
            body = "from __future__ import annotations\n" + textwrap.dedent(inspect.getsource(what))
            given = folder / "arguments.json"
            given.write_text(json.dumps(arguments, default=str), encoding="utf-8")
            call = f"result = {what.__name__}(**json.loads(pathlib.Path({str(given)!r}).read_text()))"
        else:
            body, call = what, "result = globals().get('result')"
        script = folder / "script.py"
        script.write_text(
            f"{body}\nimport json, pathlib\n{call}\npathlib.Path({str(answer)!r}).write_text(json.dumps(result))\n",
            encoding="utf-8",
        )
        paths = [str(SUPPORT), *filter(None, [os.environ.get("PYTHONPATH")])]
        process = subprocess.run(
            [sys.executable, str(script)],
            cwd=cwd or folder,
            # what a host extracts and leaves behind goes with pytest's folders
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "TMPDIR": str(folder)},
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        output = f"{process.stdout[-4000:]}\n{process.stderr[-4000:]}"
        assert process.returncode == 0, f"the process ended with {process.returncode}:\n{output}"
        return json.loads(answer.read_text(encoding="utf-8"))

    return run


@pytest.fixture(scope="session")
def build_fmu(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """`build_fmu(model, constants=None)`: path of the FMU, built once per session and xdist worker."""
    import numpy as np

    from fmi_export.building.python_fmu import build_python_fmu, guid_of
    from fmi_export.model import Model

    built: dict[str, Path] = {}

    def build(model: Model, constants: Any = None) -> Path:
        numbers = np.zeros(1) if constants is None else constants
        guid = guid_of(model, numbers)
        if guid not in built:
            built[guid] = build_python_fmu(model, numbers, tmp_path_factory.mktemp(model.name))
        return built[guid]

    return build
