"""Programs, and the command line, in separate processes."""

import subprocess
import sys
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

COMMAND = (sys.executable, "-c", "from amb_cosim.start import main; main()")


def run_program(*command: object, code: int | None = 0, **options: Any) -> CompletedProcess[str]:
    """Run a program, which must end with exit code `code`, or any code if that is None."""
    values = {"capture_output": True, "text": True, "timeout": 600, "check": False} | options
    done = subprocess.run([*map(str, command)], **values)
    assert code in (None, done.returncode), f"exit code {done.returncode}\n{done.stdout[-5000:]}\n{done.stderr[-5000:]}"
    return done


def run_command(*arguments: object, cwd: Path, code: int | None = 0, **options: Any) -> CompletedProcess[str]:
    """Run `amb-cosim` in a folder."""
    return run_program(*COMMAND, *arguments, cwd=cwd, code=code, **options)
