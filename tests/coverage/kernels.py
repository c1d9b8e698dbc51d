"""pytest plugin that tells which branches of the models the tests take, kernels compiled as ever.

    python -m pytest -p tests.coverage.kernels --branches report.json -n 0 tests/rotor_contact

What subprocesses and FMUs do does not count.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest

FMUS = Path(__file__).resolve().parents[2] / "fmus"


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--branches", metavar="FILE", type=Path, help="write lines and branches of the models there")


@pytest.hookimpl(tryfirst=True)
def pytest_load_initial_conftests(early_config: pytest.Config) -> None:
    if early_config.known_args_namespace.branches:  # before anything imports a model
        early_config.pluginmanager.register(_Measurement())


class _Measurement(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads the modules of the models with notes of their branches; keeps the line of each by file and number."""

    def __init__(self) -> None:
        import numba

        self.lines: dict[str, dict[int, int]] = {}
        self.kernels = tempfile.TemporaryDirectory()  # what is compiled here is of no use to others
        numba.config.CACHE_DIR = self.kernels.name
        sys.meta_path.insert(0, self)

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if "." not in name or spec is None or spec.origin is None or FMUS not in Path(spec.origin).parents:
            return None
        return importlib.machinery.ModuleSpec(name, self, origin=spec.origin)

    def exec_module(self, module: Any) -> None:
        from tests.coverage.branches import Notes, no, yes

        path = Path(module.__spec__.origin)
        notes = Notes(first=sum(map(len, self.lines.values())))
        tree = notes.add_to(path.read_text(encoding="utf-8"))
        self.lines[str(path.relative_to(FMUS))] = dict(enumerate(notes.lines, notes.first))
        module.__dict__.update(yes=yes, no=no, __file__=str(path))
        exec(compile(tree, str(path), "exec"), module.__dict__)

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        from tests.coverage.branches import is_taken

        report = {
            file: [[line, is_taken(number)] for number, line in numbers.items()]
            for file, numbers in sorted(self.lines.items())
        }
        session.config.getoption("--branches").write_text(json.dumps(report), encoding="utf-8")
