"""Writes docs/reference/compatibility.md from a record of test runs: `python -m tools.compatibility RECORD [PAGE]`.

`RECORD` is the file of `pytest --hosts RECORD`; see `record.py`.
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "compatibility.md"
HEAD = """# Compatibility

This page is written from test runs: `pytest --hosts hosts.json -m "host and (slow or not slow)"`, then
`python -m tools.compatibility hosts.json`. Each row names a tool that ran FMUs of this project in a test, with its
installed version. libcosim is compared at its own times, which are whole nanoseconds. "To the last bit" does not apply
to a controller with `prediction_time`, which divides by differences of times. FMPy, which sums its steps, then agrees
with this master's run within 2e-10, and libcosim within 9e-12.
[The pages on other tools](../how-to/tools/README.md) cover untested tools and further details.

"""
COLUMNS = ("tool", "version", "platform", "FMUs", "what the tests compare", "result")
RESULTS = {"passed": "yes", "failed": "**no**", "skipped": "not run"}

Row = dict[str, str]


def page(record: dict[str, Row]) -> str:
    """Return the page: a row for each tool, platform, FMUs and comparison, with the worst outcome of its tests."""
    rows: dict[tuple[str, ...], list[Row]] = defaultdict(list)
    for line in record.values():
        rows[tuple(line[key] for key in ("tool", "version", "platform", "fmus", "what"))].append(line)
    lines = [f"| {' | '.join(COLUMNS)} |", f"|{' --- |' * len(COLUMNS)}"]
    for key in sorted(rows):
        lines.append(f"| {' | '.join((*key, _result(rows[key])))} |")
    return f"{HEAD}{chr(10).join(lines)}\n"


def _result(lines: list[Row]) -> str:
    outcomes = [line["outcome"] for line in lines]
    worst = next((outcome for outcome in ("failed", "passed") if outcome in outcomes), "skipped")
    reasons = sorted({line["reason"] for line in lines if line["reason"]}) if worst == "skipped" else []
    tests = f" ({outcomes.count('passed')} tests)" if worst == "passed" and len(outcomes) > 1 else ""
    return "; ".join((f"{RESULTS[worst]}{tests}", *reasons))


if __name__ == "__main__":
    record, target = Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else PAGE
    target.write_text(page(json.loads(record.read_text(encoding="utf-8"))), encoding="utf-8")
