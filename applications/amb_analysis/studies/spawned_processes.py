"""Python processes started by multiprocessing's method `spawn`, each of which imports the script that Python runs."""

from __future__ import annotations

import multiprocessing
import sys
from multiprocessing import process
from pathlib import Path


def end_if_imported_anew() -> None:
    """End a new process that called this as it imported a script without a main guard; see `main_guard_advice`."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(1)


def check_script() -> None:
    """Check that new processes can import the script that Python runs, if it runs one.

    Raises
    ------
    ValueError
        If the script is not a file: Python reads it from standard input, or it was moved or deleted.
    """
    main = sys.modules["__main__"]
    script = getattr(main, "__file__", None)
    if script is None or getattr(main, "__spec__", None) is not None:
        return  # an interactive session, or a module that processes import by name
    if not Path(getattr(process, "ORIGINAL_DIR", None) or "", script).is_file():
        is_input = script == "<stdin>"
        reason = "Python reads the script from standard input" if is_input else f"the script {script} is no file"
        raise ValueError(f"{reason}, but the processes started here must import the script; save it as a file")


def main_guard_advice(function: str) -> str:
    """Return the advice for a script whose call of `function` ended the processes that imported the script."""
    return f'a script must call {function} below if __name__ == "__main__":, since each process imports it'
