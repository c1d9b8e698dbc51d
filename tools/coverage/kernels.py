"""pytest plugin that reports which branches of the models the tests take, with compiled kernels.

    python -m pytest -p tools.coverage.kernels --branches report.json -n 0 tests/rotor_contact

Branches taken in subprocesses and FMUs are not counted.
"""

from __future__ import annotations

import ast
import json
from pathlib import Path

import pytest

from tools.coverage.branches import BranchSwitches
from tools.instruments.loading import ChangedSources

FMUS = Path(__file__).resolve().parents[2] / "fmus"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--branches", metavar="FILE", type=Path, help="write lines and branches of the models there")


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    if early_config.known_args_namespace.branches:  # before anything imports a model
        early_config.pluginmanager.register(_Measurement())


class _Measurement:
    """Keeps the line of each branch by file and number."""

    def __init__(self) -> None:
        self.lines: dict[str, dict[int, int]] = {}
        ChangedSources(lambda path: FMUS in path.parents, self._with_switches)

    def _with_switches(self, path: Path) -> ast.Module:
        switches = BranchSwitches(first=1 + sum(map(len, self.lines.values())))
        tree = switches.add_to(path.read_text(encoding="utf-8"))
        self.lines[str(path.relative_to(FMUS))] = dict(enumerate(switches.lines, switches.first))
        return tree

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        from tools.instruments.switch import reached

        taken = reached()
        report = {
            file: [[line, number in taken] for number, line in numbers.items()]
            for file, numbers in sorted(self.lines.items())
        }
        session.config.getoption("--branches").write_text(json.dumps(report), encoding="utf-8")
