"""pytest plugin that records which hosts ran which FMUs, with the option `--hosts FILE`.

A marker states what a test runs; the plugin writes an entry of a JSON file for it, with the outcome of the test and the
version of the installed distribution or program.

    @pytest.mark.host("a host in C under wine", "wine", platform="Windows x86_64", fmus="a probe", what="its data")

`host_marks.py` in tests/support has the marks of tools that are Python distributions.
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
    """Plugin of every pytest process: workers pass on what a test runs, the main process records it."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.entries: dict[str, dict[str, str]] = {}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        for item in items:
            for marker in item.iter_markers(PROPERTY):
                tool, source = (*marker.args, "")[:2]
                item.user_properties.append((PROPERTY, {"tool": tool, "source": source, **marker.kwargs}))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        for name, facts in report.user_properties:
            if name == PROPERTY and (report.when == "call" or report.outcome != "passed"):
                assert isinstance(facts, dict)
                self.entries[f"{report.nodeid} {facts['tool']}"] = _line(facts, report)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Add the entries to the file, in place of earlier ones of the same tests."""
        if hasattr(session.config, "workerinput") or not self.entries:
            return
        before = json.loads(self.file.read_text(encoding="utf-8")) if self.file.is_file() else {}
        text = json.dumps(before | self.entries, indent=1, sort_keys=True)
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
    """Return the version of a distribution of Python, or of a program; empty if neither is installed."""
    if not source:
        return ""
    try:
        return importlib.metadata.version(source)
    except importlib.metadata.PackageNotFoundError:
        program = shutil.which(source)
    if program is None:
        return ""
    output = subprocess.run([program, "--version"], capture_output=True, text=True, timeout=60, check=False).stdout
    match = re.search(r"\d+(\.\d+)+", output)
    return match[0] if match else ""
