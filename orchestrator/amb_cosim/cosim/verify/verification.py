"""Runs the experiments that an FMU carries (FMI-LS-REF) in a process of its own, and compares with its results."""

from __future__ import annotations

import queue
import time
from dataclasses import dataclass
from pathlib import Path

from amb_cosim.cosim.basics.cache import unpacked
from amb_cosim.cosim.basics.errors import ProcessFailed
from amb_cosim.cosim.run.isolation import (
    ERROR,
    LONGEST_SILENCE,
    POLL_TIME,
    RECORDING,
    end_group,
    has_process_ended,
    how_it_ended,
    last_message,
    messages_of,
    own_process,
)

TOLERANCE = 1e-6  # of the largest value of a variable, within which values of other machines are equal
MOST_TOLERANCE = 1e-3  # of the same, that an experiment may allow itself


@dataclass(frozen=True)
class Deviation:
    """A value that is not that of the reference: where, when (s), both, and the difference by the largest reference."""

    variable: str
    time: float
    expected: float
    found: float
    relative: float


@dataclass(frozen=True)
class Verified:
    """An experiment that was run: how many points and values were compared, and which deviates most, None if none does.

    `failure` is why the FMU did not get through, `unread` why the experiment was not run. `allowed` is the tolerance
    that the experiment asks for, which `tolerance` caps.
    """

    experiment: str
    tolerance: float
    n_points: int = 0
    n_values: int = 0
    largest: Deviation | None = None
    failure: str = ""
    unread: str = ""
    allowed: float = 0.0

    @property
    def is_equal(self) -> bool:
        """Whether all values are those of the reference, within the tolerance."""
        if self.failure or self.unread or self.n_values == 0:
            return False
        return self.largest is None or self.largest.relative <= self.tolerance

    def __str__(self) -> str:
        return _printable(f"{self.experiment}: {self._verdict()}")

    def _verdict(self) -> str:
        if self.unread:
            return f"not run, {self.unread}"
        if self.failure:
            return f"NOT equal, the FMU failed: {self.failure}"
        compared = f"{self.n_values} values at {self.n_points} points"
        if self.largest is None:
            return f"equal to the last bit, {compared}"
        d = self.largest
        cap = f" (the experiment allows {self.allowed:g}, which is too much)" if self.allowed > self.tolerance else ""
        verdict = f"{'equal' if self.is_equal else 'NOT equal'} within {self.tolerance:g}{cap}"
        where = f"{d.variable} = {d.found!r}, reference {d.expected!r}, at t = {d.time:.9g} s"
        return f"{verdict}, {compared}; largest deviation {d.relative:.3g} of the largest value, {where}"


def _printable(text: str) -> str:
    """Return a text with line breaks and control characters escaped: an FMU may name its experiments as it likes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def verify(fmu: str | Path) -> list[Verified]:
    """Run the experiments that an FMU carries as FMI-LS-REF lays them out, and compare with their reference results.

    It is run by FMPy in a process of its own. Values are equal within 1e-6 of a variable's largest reference, or the
    experiment's `tolerance` if that is more, 1e-3 at most.

    Raises
    ------
    ValueError
        If the file is no FMU, carries no experiment, or one that is wrong.
    ProcessFailed
        If the FMU crashed, or did not come to an end.
    """
    path = Path(fmu)
    if not path.is_file():
        raise ValueError(f"there is no FMU {fmu}")
    folder, _ = unpacked(path, f"FMU {fmu}")
    with own_process("verify.verification_process", (folder,)) as process:
        messages, start = messages_of(process), time.monotonic()
        while True:
            ended = has_process_ended(process)
            try:
                kind, *content = messages.get(timeout=POLL_TIME)
                break
            except queue.Empty:
                if ended:
                    end_group(process)
                    kind, *content = last_message(messages)
                    break
                if time.monotonic() > start + LONGEST_SILENCE:
                    raise ProcessFailed(f"{fmu} did not get through its experiments in {LONGEST_SILENCE:g} s") from None
        if kind == ERROR:
            raise ValueError(_printable(f"{fmu}: {content[0]}")) from content[0]
        if kind != RECORDING:
            raise ProcessFailed(f"the process of {fmu} {how_it_ended(process.wait())}; nothing was verified")
    result: list[Verified] = content[0]
    if not result:
        raise ValueError(f"{fmu} carries no experiment with reference results (FMI-LS-REF); there is nothing to verify")
    return result
