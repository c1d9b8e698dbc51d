"""An FMU that misbehaves at one of its calls; see `hostile.c`."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from waiting import of_process

from tests.support.c_fmus import ANY_STEP, INPUT, OUTPUT, described

SOURCE = Path(__file__).parent / "hostile.c"
# After these the run continues.
HARMLESS = ("nothing", "fork", "fork_away", "daemon", "print", "deaf", "latin", "complain", "inf")
DEEDS = (
    *HARMLESS, "eat", "segv", "abort", "leave", "kill", "overflow", "hang", "speak", "close", "term", "free_twice",
    "error", "fatal", "discard", "nan", "minus_one", "ninety_nine",
)  # fmt: skip
DESCRIPTIONS = {
    version: described(
        "Hostile", [("u", INPUT, 'Real start="0"'), ("y", OUTPUT, "Real")], version, f'{ANY_STEP} {saves}="true"'
    )
    for version, saves in ((2, "canGetAndSetFMUstate"), (3, "canGetAndSetFMUState"))
}


class Hostility:
    """What the FMUs of a test will do, and the processes that they have started.

    Attributes
    ----------
    fmu
        `fmu(version)`: path of the FMU.
    """

    def __init__(self, fmu_from_c: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> None:
        self.fmu = lambda version: fmu_from_c(SOURCE, DESCRIPTIONS[version], version)
        self._set = monkeypatch.setenv
        self._mark = ""

    def will(self, deed: str, call: int, function: str | None = None) -> None:
        """Let FMUs do this at a call, counted from 0: of all functions or of one."""
        assert deed in DEEDS
        self._mark = f"{os.getpid()}-{os.urandom(4).hex()}"
        values = {"DEED": deed, "CALL": call, "MARK": self._mark} | ({"FUNCTION": function} if function else {})
        for name, value in values.items():
            self._set(f"HOSTILE_{name}", str(value))

    def processes(self) -> set[int]:
        """Return the numbers of the processes started since the last call of `will`."""
        return {process for process in _processes() if self._mark in of_process(process, "environ")}

    def hangs(self) -> bool:
        """Whether one of them hangs in a call, which gives its thread a name."""
        threads = (
            (number, thread.name) for number in self.processes() for thread in Path(f"/proc/{number}/task").glob("*")
        )
        return any(of_process(number, f"task/{thread}/comm") == "hangs\n" for number, thread in threads)


def _processes() -> list[int]:
    numbers = (int(process.name) for process in Path("/proc").glob("[0-9]*"))
    return [number for number in numbers if number != os.getpid()]
