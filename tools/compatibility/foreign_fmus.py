"""Writes docs/validation/foreign_fmus.md: runs of other tools' FMUs, compared with FMPy.

    python -m tools.compatibility.foreign_fmus FOLDER ... [--page PAGE]

Both run the co-simulation FMUs of the folders alone, with the same communication steps, start values and constant
inputs. The difference of an output y is

    max |y_n - y_n(FMPy)|,    n = 0, 1, ..., of all recorded times t_n = t_0 + n h                    (1)

FMUs run in other processes, with all your permissions. Equal files are compared once.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tools.compatibility.foreign_runs import RUNNERS, Columns

PAGE = Path(__file__).parents[2] / "docs" / "validation" / "foreign_fmus.md"
HEAD = """# Other tools' FMUs, compared with FMPy

`python -m tools.compatibility.foreign_fmus FOLDER ...` writes this page. This master and FMPy {version} ran each FMU
alone, with its start values, constant inputs, and the step and the stop time of its default experiment. Each row lists
the FMUs of a tool, the total numbers of their outputs and recorded times, and the largest difference.

A run has at most {most} steps. If an FMU accepts any step, the step is the next smaller power of 2, whose multiples are
exact. FMPy's steps are differences of times, and their rounding could otherwise move an event by a step. The
Sensor_Block FMUs draw random numbers, so even two runs in FMPy can differ by 2.

The FMUs are for 64-bit Linux and come from the public repositories of [Reference
FMUs](https://github.com/modelica/Reference-FMUs), [Ecos](https://github.com/Ecos-platform/ecos),
[libcosim](https://github.com/open-simulation-platform/libcosim), [FMI4j](https://github.com/NTNU-IHB/FMI4j),
[OMSimulator](https://github.com/OpenModelica/OMSimulator) and
[Maestro](https://github.com/INTO-CPS-Association/maestro), and from the packages crane-fmu and gemseo-fmu.

"""
COLUMNS = ("tool", "FMI", "FMUs", "outputs", "times", "largest difference")
MOST_STEPS = 1000
LONGEST = 300.0  # s without a new FMU started, after which a process is ended
EMPTY = ("String", "Binary", "Clock")  # types without numbers


class Comparison(NamedTuple):
    """An FMU of the page; `difference` is NaN, and `note` the reason, if this master cannot run the FMU."""

    name: str
    tool: str
    fmi: str
    outputs: int = 0
    times: int = 0
    difference: float = float("nan")
    note: str = ""


def compare(fmus: Iterable[Path]) -> list[Comparison]:
    """Return the result of each FMU that FMPy can run in co-simulation; print why others are omitted."""
    described = [(fmu, request) for fmu in fmus if (request := describe(fmu)) is not None]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        requests = Path(folder) / "requests.json"
        requests.write_text(json.dumps([request for _, (_, request) in described]), encoding="utf-8")
        results = {}
        for runner in RUNNERS:
            place = Path(folder) / runner
            place.mkdir()
            results[runner] = run_all(runner, requests, place, len(described))
        for k, (fmu, (row, _)) in enumerate(described):
            reference, ours = (results[runner][k] for runner in ("fmpy", "this_master"))
            if isinstance(reference, str):
                print(f"{fmu}: FMPy: {reference}")
            else:
                rows.append(row._replace(**({"note": ours} if isinstance(ours, str) else difference(ours, reference))))
    return rows


def describe(fmu: Path) -> tuple[Comparison, dict[str, Any]] | None:
    """Return the row of an FMU, without result, and the request; None if it has no co-simulation for this platform."""
    from fmpy import platform, platform_tuple, read_model_description, supported_platforms

    try:
        description = read_model_description(str(fmu), validate=False)
    except Exception as error:
        print(f"{fmu}: {error}")
        return None
    if description.coSimulation is None or {platform, platform_tuple}.isdisjoint(supported_platforms(str(fmu))):
        return None
    outputs = [v.name for v in description.modelVariables if v.causality == "output" and v.type not in EMPTY]
    request = {"fmu": str(fmu.resolve()), "outputs": outputs, **experiment(description.defaultExperiment)}
    if description.coSimulation.canHandleVariableCommunicationStepSize:
        request |= exact_steps(request)
    return Comparison(fmu.stem, description.generationTool or "", description.fmiVersion), request


def experiment(default: Any) -> dict[str, float]:
    """Return start, stop and communication step (s) of a default experiment, with at most `MOST_STEPS` steps."""
    start, stop, step = (
        float(value) if value else other
        for value, other in (
            (getattr(default, "startTime", None), 0.0),
            (getattr(default, "stopTime", None), 0.0),
            (getattr(default, "stepSize", None), 0.0),
        )
    )
    stop = stop if stop > start else start + 1.0
    step = step if 0.0 < step <= stop - start else (stop - start) / 100
    steps = min(MOST_STEPS, round((stop - start) / step))
    return {"start": start, "stop": start + steps * step, "step": step}


def exact_steps(run: dict[str, Any]) -> dict[str, float]:
    """Return step and stop time (s) with the largest power of 2 up to the step, of which all multiples are exact.

    FMPy steps by differences of times. Their rounding moves events by a step, and adaptive solvers within tolerance.
    """
    step = 2.0 ** math.floor(math.log2(run["step"]))
    steps = min(MOST_STEPS, math.floor((run["stop"] - run["start"]) / step))
    return {"step": step, "stop": run["start"] + steps * step}


def run_all(runner: str, requests: Path, folder: Path, count: int) -> list[Columns | str]:
    """Return the columns of each FMU, or why it failed; a process that ends early or hangs is replaced."""
    while len(list(folder.iterdir())) < count:
        command = [sys.executable, "-m", "tools.compatibility.foreign_runs", runner, str(requests), str(folder)]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            while process.poll() is None:
                started = len(list(folder.iterdir()))
                with suppress(subprocess.TimeoutExpired):
                    process.wait(LONGEST)
                if len(list(folder.iterdir())) == started:
                    process.kill()
    return [_result(folder / f"{k}.npz") for k in range(count)]


def _result(values: Path) -> Columns | str:
    if not values.exists():
        return values.with_suffix(".txt").read_text(encoding="utf-8")
    with np.load(values) as data:
        return {**data}


def difference(ours: Columns, reference: Columns) -> dict[str, Any]:
    """Return the fields of a row: the largest difference (1) at the times that both recorded."""
    n = min(len(ours["time"]), len(reference["time"]))
    more = len(reference["time"]) - n
    largest = 0.0
    for name in reference:
        a, b = ours[name][:n], reference[name][:n]
        gaps = np.where(np.isnan(a) | np.isnan(b), np.where(np.isnan(a) & np.isnan(b), 0.0, np.inf), np.abs(a - b))
        largest = max(largest, float(np.max(gaps, initial=0.0)))
    note = f"FMPy recorded {more} more" if more else ""
    return {"outputs": len(reference) - 1, "times": n, "difference": largest, "note": note}


def distinct(folders: Iterable[Path]) -> Iterator[Path]:
    """Yield the FMUs of folders; equal files only once."""
    digests = set()
    for file in sorted(file for folder in folders for file in folder.rglob("*") if file.suffix.lower() == ".fmu"):
        digest = hashlib.sha256(file.read_bytes()).digest()
        if digest not in digests:
            digests.add(digest)
            yield file


def page(rows: Iterable[Comparison]) -> str:
    """Return the page: a table with a row for the FMUs of a tool that agree equally well."""
    from importlib.metadata import version

    groups = defaultdict(list)
    for row in sorted(set(rows)):
        value = row.note if np.isnan(row.difference) else "; ".join(filter(None, (f"{row.difference:.2g}", row.note)))
        groups[row.tool or "not stated", row.fmi, value].append(row)
    lines = [f"| {' | '.join(COLUMNS)} |", f"|{' --- |' * len(COLUMNS)}"]
    for (tool, fmi, value), same in sorted(groups.items()):
        names = ", ".join(dict.fromkeys(row.name for row in same))
        cells = (tool, fmi, names, str(sum(row.outputs for row in same)), str(sum(row.times for row in same)), value)
        lines.append(f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |")
    return HEAD.format(version=version("fmpy"), most=MOST_STEPS) + "\n".join(lines) + "\n"


def main() -> None:
    """Compare the FMUs of folders and write the page."""
    parser = argparse.ArgumentParser(prog="python -m tools.compatibility.foreign_fmus")
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--page", type=Path, default=PAGE)
    options = parser.parse_args()
    options.page.write_text(page(compare(distinct(options.folders))), encoding="utf-8")


if __name__ == "__main__":
    main()
