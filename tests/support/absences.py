"""Lists why tests were skipped, and fails a run in which one was skipped for a reason that is not on a list."""

import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

import pytest


class Absences:
    """A plugin of pytest's main process.

    The list is a TOML file: beginnings of the reasons that pytest shows for a skipped test, and why each is allowed.
    """

    def __init__(self, file: Path) -> None:
        self.allowed: dict[str, str] = tomllib.loads(file.read_text(encoding="utf-8"))
        self.lines: list[str] = []

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Sort the reasons, and fail the run for one that is not on the list."""
        reporter: Any = session.config.pluginmanager.get_plugin("terminalreporter")
        reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in reporter.stats.get("skipped", []))
        for reason, count in sorted(reasons.items()):
            why = next((why for start, why in self.allowed.items() if reason.startswith(start)), None)
            self.lines.append(f"{count} x {reason} ({why or 'NOT ALLOWED'})")
            if why is None and session.exitstatus == pytest.ExitCode.OK:
                session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print the reasons, each once."""
        terminalreporter.section("skipped")
        for line in self.lines:
            terminalreporter.line(line)
