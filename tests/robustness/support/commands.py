"""Runs command lines of `amb-cosim`, each in a separate process with limits of time."""

from __future__ import annotations

import os
import re
import resource
import signal
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

# Cases of each kind, a few in every test run; command lines and ten kinds of files make more than 8000 in a long one.
FEW, MANY, LONG = 2, 10, 800

TIME = 10  # s of CPU time after which a command is stopped; CPU time does not depend on the load of the machine
WAIT = 300.0  # s of wall-clock time after which it is stopped, because it may wait without using the CPU
MEMORY = 2e9  # bytes that a command may take
GRACE = 60  # s that it then has: an FMU of flavour python compiles its kernels first, and cannot be stopped in that

OF_LIBRARIES = re.compile(  # which name neither the file nor the cause
    r"array element|inhomogeneous|arg(?:min|max)|zip\(\)|broadcast|NoneType|unhashable|index out of|not subscriptable"
    r"|has no attribute|object is not|unexpected keyword|positional argument|too many values|to unpack"
)


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit code, or minus the number of a signal; `stopped`: it reached a limit of time.

    `used` is CPU time in s, `memory` is in bytes.
    """

    code: int
    stopped: bool
    used: float
    memory: float
    output: str
    errors: str
    written: tuple[str, ...]

    def mistake(self) -> str | None:
        """What is wrong with that, if anything is."""
        if self.code not in ((0, 1, 2, 130, 143) if self.stopped else (0, 1, 2)):
            return f"exit code {self.code}"
        if self.memory > MEMORY:
            return f"{self.memory / 1e9:.2g} GB of memory"
        if "Traceback" in self.errors or "Traceback" in self.output:
            return "a traceback"
        if self.code in (1, 2) and not self.errors.strip():
            return "no message"
        if self.code == 2 and (words := OF_LIBRARIES.search(self.errors)):
            return f"a message of a library: {words[0]!r}"
        if self.code == 2 and len(self.errors) > 20_000:
            return "an endless message"
        if self.code == 2 and self.written:
            return f"wrong input, and {self.written} written"
        if any(Path(name).name.startswith(".amb-cosim-") for name in self.written):
            return f"{self.written} left behind"
        return None


Content = bytes | Callable[[Path], object]  # of a file: its bytes, or what makes it at a path


def many(test: Callable[..., None]) -> Any:
    """Mark a test that runs with many cases alone, and not in every test run."""
    return pytest.mark.slow(pytest.mark.parametrize("n_cases", [MANY], indirect=True, ids=["many"])(test))


def run(
    arguments: Sequence[str],
    folder: Path,
    files: Mapping[str, Content],
    time_limit: int = TIME,
    before: Callable[[], None] | None = None,
) -> Ended:
    """Run a command line in a new folder with these files, in a fork of this process, after a call of `before`.

    It may take `time_limit` (s) of CPU time.
    """
    folder.mkdir()
    for name, content in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        if isinstance(content, bytes):
            (folder / name).write_bytes(content)
        else:
            content(folder / name)
    output, errors = folder.with_suffix(".out"), folder.with_suffix(".err")
    number = os.fork()
    if number == 0:
        code = 70
        try:
            os.chdir(folder)
            signal.signal(signal.SIGXCPU, _stop)
            resource.setrlimit(resource.RLIMIT_CPU, (time_limit, time_limit + GRACE))
            for descriptor, path in ((1, output), (2, errors)):
                os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), descriptor)
            sys.stdin = open(os.devnull)  # noqa: PTH123, SIM115
            sys.stdout = os.fdopen(1, "w", encoding="utf-8", errors="backslashreplace")
            sys.stderr = os.fdopen(2, "w", encoding="utf-8", errors="backslashreplace")
            if before is not None:
                before()
            code = _code_of(arguments)
        except BaseException:
            import traceback

            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    stopped, status = False, None
    begin = time.monotonic()
    limits = [(begin + WAIT, signal.SIGTERM), (begin + WAIT + GRACE, signal.SIGKILL)]
    while status is None:
        ended, result, used = os.wait4(number, os.WNOHANG)
        if ended:
            status = result
        elif limits and time.monotonic() > limits[0][0]:
            os.kill(number, limits.pop(0)[1])
            stopped = True
        else:
            time.sleep(0.002)
    seconds = used.ru_utime + used.ru_stime
    written = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file())
    texts = [path.read_text(encoding="utf-8", errors="replace") if path.is_file() else "" for path in (output, errors)]
    same = {name for name, content in files.items() if callable(content) or _is(folder / name, content)}
    new = tuple(name for name in written if name not in same)
    code = os.waitstatus_to_exitcode(status)
    stopped = stopped or code == 128 + signal.SIGTERM or seconds >= time_limit
    return Ended(code, stopped, seconds, 1024.0 * used.ru_maxrss, texts[0], texts[1], new)


def _is(path: Path, content: bytes) -> bool:
    return path.is_file() and path.read_bytes() == content


def _stop(number: int, _: object) -> None:
    signal.signal(number, signal.SIG_IGN)  # it is sent each second
    signal.raise_signal(signal.SIGTERM)


def _code_of(arguments: Sequence[str]) -> int:
    from amb_cosim.commands.cli import main

    try:
        main(list(arguments), prog_name="amb-cosim")
    except SystemExit as end:
        return int(end.code or 0)
    return 0
