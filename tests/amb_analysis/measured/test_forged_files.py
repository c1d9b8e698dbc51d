"""Forged files of measured data: each is read right or refused with a sentence, in a process with limits."""

from __future__ import annotations

import os
import resource
import signal
import traceback
import warnings
from pathlib import Path

import numpy as np
import pytest

from amb_cosim import studies
from tests.amb_analysis.measured.forged_files import Case, F, H, cases, polar_tables, table

pytest.importorskip("pyuff")
if not Path("/proc/self/statm").exists():
    pytest.skip("the limits are those of Linux", allow_module_level=True)

SECONDS, BYTES = 10, 2 * 2**30
PAGE = Path(__file__).parents[3] / "docs/how-to/measured.md"
SAMPLE = 20
FOUND = (  # read as other numbers, or left out, or with a warning of numpy beside the message
    *("'1_0' in column 1", "'٣' in column 2", "'#REF!' in column 0", "'inf' in column 1", "59 points announced"),
    "infinite response in npz",
    *(case.title for case in polar_tables()),
)


def outcome(case: Case, folder: Path, rotor: Path) -> str:
    """Return what becomes of a case: `true`, `refused`, `wrong data`, or what broke."""
    (folder / case.file).write_bytes(case.content)
    try:
        result = studies.response(rotor=rotor, measured=folder / case.file, **case.options)
    except ValueError as error:
        return "refused" if "\n" not in str(error) and len(str(error)) > 20 else f"the message {error}"
    curves = result.responses.values()
    same = all(np.array_equal(c.frequencies, F) and np.allclose(c.measured, H, rtol=1e-4) for c in curves)
    return "true" if same else "wrong data"


def limited(case: Case, folder: Path, rotor: Path) -> str:
    """Return the outcome of a process of its own with limits of time and memory."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
        used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (used + BYTES, used + BYTES))
        warnings.simplefilter("error", RuntimeWarning)
        try:
            text = outcome(case, folder, rotor)
        except BaseException:
            text = traceback.format_exc()[-1500:]
        os.write(writing, text.encode(errors="replace")[:4000])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as stream:
        text = stream.read().decode(errors="replace")
    _, status = os.waitpid(child, 0)
    return text if status == 0 else f"ended by {signal.Signals(status & 0x7F).name} after {SECONDS} s or {BYTES} B"


def faults(chosen: list[Case], folder: Path) -> list[str]:
    """Return the cases with another outcome than expected."""
    rotor = folder / "fan.toml"
    rotor.write_text(PAGE.read_text().partition("# fan.toml")[2].partition("```")[0])
    # What a case needs is loaded into this process, whose forks the others are: loading takes seconds.
    assert outcome(Case("whole", "t.csv", table().encode(), "true"), folder, rotor) == "true"
    allowed = {"either": ("true", "refused"), "anything": ("true", "refused", "wrong data")}
    result = []
    for case in chosen:
        found = limited(case, folder, rotor)
        if found not in allowed.get(case.expected, (case.expected,)):
            result.append(f"{case.file}, {case.title}: {found}, expected {case.expected}")
    return result


def test_what_campaigns_found_is_read_right_or_refused(tmp_path, first_seed):
    chosen = [case for case in cases(first_seed, 0) if case.title in FOUND]
    assert len(chosen) == len(FOUND)
    assert faults(chosen, tmp_path) == []


def test_a_sample_of_forged_files_is_read_right_or_refused(tmp_path, first_seed):
    every = cases(first_seed, 40)
    chosen = every[:: len(every) // SAMPLE]
    assert faults(chosen, tmp_path) == []


@pytest.mark.slow
def test_all_forged_files_are_read_right_or_refused(tmp_path, first_seed, is_long):
    every = cases(first_seed, 2000 if is_long else 80)
    assert len(every) > 250
    assert faults(every, tmp_path) == []
