"""The command line in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

COMMAND = (sys.executable, "-c", "from amb_cosim.start import main; main()")


def run_command(*arguments: object, cwd: Path, code: int | None = 0, **options: Any) -> CompletedProcess[str]:
    """Run `amb-cosim` in a folder; it ends with `code`, or as it likes if that is None."""
    values = {"capture_output": True, "text": True, "timeout": 600, "check": False} | options
    done = subprocess.run([*COMMAND, *map(str, arguments)], cwd=cwd, **values)
    assert code in (None, done.returncode), f"{done.stdout}\n{done.stderr}"
    return done
