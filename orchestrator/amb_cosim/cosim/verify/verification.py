"""Runs the experiments in an FMU (FMI-LS-REF) in a separate process, and compares them with its reference results."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

from amb_cosim.cosim.building.cache import unpacked
from amb_cosim.cosim.errors import ProcessFailed
from amb_cosim.cosim.fmu.fmus import Fmu, note_first_loading
from amb_cosim.cosim.processes.child_process import child_process, how_it_ended
from amb_cosim.cosim.run.isolation import ERROR, LONGEST_SILENCE, RECORDING, messages_of, next_message
from amb_files.checks import as_path

TOLERANCE = 1e-6  # of the largest value of a variable; results of different machines agree within this
MOST_TOLERANCE = 1e-3  # of the same; the largest tolerance that an experiment may set


@dataclass(frozen=True)
class Deviation:
    """A value that differs from the reference; `relative` is the difference relative to the largest reference."""

    variable: str
    time: float
    expected: float
    computed: float
    relative: float


@dataclass(frozen=True)
class Verified:
    """Result of an experiment: numbers of compared points and of compared values, and the largest deviation, if any.

    `failure` is the reason why the FMU failed, and `unread` is the reason why the experiment was not run. `allowed` is
    the tolerance that the experiment states; `tolerance` is the applied tolerance, which has limits. `omitted` are
    columns of the references that are not compared, with the reason; `other_text` is the first text that differs from
    its reference.
    """

    experiment: str
    tolerance: float
    n_points: int = 0
    n_values: int = 0
    largest: Deviation | None = None
    failure: str = ""
    unread: str = ""
    allowed: float = 0.0
    omitted: tuple[str, ...] = ()
    other_text: str = ""

    @property
    def is_equal(self) -> bool:
        """Whether all values match the reference within the tolerance."""
        if self.failure or self.unread or self.other_text or self.n_values == 0:
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
        if self.omitted:
            compared += f" (not compared: {', '.join(self.omitted)})"
        if self.other_text:
            return f"NOT equal, {compared}; {self.other_text}"
        if self.largest is None:
            return f"equal to the last bit, {compared}"
        d = self.largest
        cap = f" (the experiment allows {self.allowed:g}, which is too large)" if self.allowed > self.tolerance else ""
        verdict = f"{'equal' if self.is_equal else 'NOT equal'} within {self.tolerance:g}{cap}"
        where = f"{d.variable} = {d.computed!r}, reference {d.expected!r}, at t = {d.time:.9g} s"
        return f"{verdict}, {compared}; largest deviation {d.relative:.3g} of the largest value, {where}"


def _printable(text: str) -> str:
    """Return a text with line breaks and control characters escaped, because names of experiments can be arbitrary."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def verify(fmu: str | Path) -> list[Verified]:
    """Run the experiments in an FMU (FMI-LS-REF), and compare the results with the reference results.

    FMPy runs the FMU in a separate process. Values must agree within 1e-6 of a variable's largest reference, or within
    the experiment's `tolerance` if that is larger (at most 1e-3). Binaries and inputs are not compared, nor are
    parameters that the experiment sets; the result names all of these. An experiment verifies nothing if its references
    are only at the start, or if the run ends before them.

    Raises
    ------
    ValueError
        If the file is not an FMU, or contains no experiment or an invalid one.
    ProcessFailed
        If the FMU crashed or did not end.

    Examples
    --------
    >>> import amb_cosim
    >>> fmu = amb_cosim.build_assembled("fmus", "compressor_levitated")
    >>> [(result.experiment, result.failure) for result in verify(fmu)]
    [('smoke_test', '')]
    """
    path = as_path("fmu", fmu)
    if not path.is_file():
        raise ValueError(f"there is no FMU {fmu}")
    folder = unpacked(path, f"FMU {fmu}")
    note_first_loading(Fmu(path, folder, "file"))
    with child_process("verify.verification_process", (folder,)) as process:
        messages, start = messages_of(process), time.monotonic()
        while (answer := next_message(process, messages)) is None:
            if time.monotonic() > start + LONGEST_SILENCE:
                raise ProcessFailed(f"{fmu} did not complete its experiments within {LONGEST_SILENCE:g} s")
        kind, *content = answer
        if kind == ERROR:
            raise ValueError(_printable(f"{fmu}: {content[0]}")) from content[0]
        if kind != RECORDING:
            raise ProcessFailed(f"the process of {fmu} {how_it_ended(process.wait())}; nothing was verified")
    result: list[Verified] = content[0]
    if not result:
        raise ValueError(
            f"{fmu} contains no experiment with reference results (FMI-LS-REF); there is nothing to verify"
        )
    return result
