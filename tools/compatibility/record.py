"""A plugin of pytest that writes down which hosts ran which FMUs, with the option `--hosts FILE`.

Tests say what they run by a marker, which this turns into lines of a JSON file: the outcome is that of the test, the
version that of the distribution or program that is installed.

    @pytest.mark.host("a host in C under wine", "wine", platform="Windows x86_64", fmus="a probe", what="its data")

`host_marks.py` in tests/support has the mark of the tools that are distributions of Python.
"""

from __future__ import annotations

import importlib.metadata
import json
import platform
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import pytest

PROPERTY = "host"  # of a report


class HostRecord:
    """A plugin of every process of pytest: workers hand on what a test runs, the main process writes it down."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.found: dict[str, dict[str, str]] = {}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            for marker in item.iter_markers(PROPERTY):
                tool, source = (*marker.args, "")[:2]
                item.user_properties.append((PROPERTY, {"tool": tool, "source": source, **marker.kwargs}))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name, facts in report.user_properties:
            if name == PROPERTY and (report.when == "call" or report.outcome != "passed"):
                assert isinstance(facts, dict)
                self.found[f"{report.nodeid} {facts['tool']}"] = _line(facts, report)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Add what was run to the file, in place of what the same tests had there."""
        if hasattr(session.config, "workerinput") or not self.found:
            return
        before = json.loads(self.file.read_text(encoding="utf-8")) if self.file.is_file() else {}
        text = json.dumps(before | self.found, indent=1, sort_keys=True)
        self.file.write_text(f"{text}\n", encoding="utf-8")


def _line(facts: dict[str, Any], report: pytest.TestReport) -> dict[str, str]:
    reason = report.longrepr[2].removeprefix("Skipped: ") if isinstance(report.longrepr, tuple) else ""
    return {
        "tool": facts["tool"],
        "version": version_of(facts["source"]),
        "platform": facts.get("platform") or f"{platform.system()} {platform.machine()}",
        "fmus": facts["fmus"],
        "what": facts["what"],
        "outcome": report.outcome,
        "reason": reason,
    }


@cache
def version_of(source: str) -> str:
    """Return the version of a distribution of Python, or of a program; empty where there is neither."""
    if not source:
        return ""
    try:
        return importlib.metadata.version(source)
    except importlib.metadata.PackageNotFoundError:
        program = shutil.which(source)
    if program is None:
        return ""
    text = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=60, check=False).stdout
    result = re.search(r"\d+(\.\d+)+", text)
    return result[0] if result else ""
