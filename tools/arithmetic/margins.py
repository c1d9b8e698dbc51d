"""pytest plugin that notes how near each numeric comparison of a test comes to its limit.

An error of 0.7 where 1 is allowed has the margin 0.7, and so has a value of 1 that must be above 0.7. Observed are
`pytest.approx`, `numpy.testing.assert_allclose`, and asserted `<`, `<=`, `>`, `>=` between two numbers.
"""

from __future__ import annotations

import ast
import json
import os
import re
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from _pytest.assertion import util

TESTS = Path(__file__).resolve().parents[2] / "tests"
NUMPY_SCALAR = re.compile(r"np\.(?:float64|int64|float32|bool)\(([^()]*)\)")

ApproxScalar: Any = type(pytest.approx(1.0))

_margins: dict[str, dict[str, float]] = {}
_running: list[str] = []


def pytest_configure(config: pytest.Config) -> None:
    compare, allclose = ApproxScalar.__eq__, np.testing.assert_allclose

    def noted_eq(self: Any, actual: Any) -> bool:
        equal = compare(self, actual)
        try:
            tolerance, error = float(self.tolerance), abs(float(actual) - float(self.expected))
        except (TypeError, ValueError):
            return equal
        if equal and tolerance > 0.0:
            _note("approx", error / tolerance)
        return equal

    def noted_allclose(actual: Any, desired: Any, rtol: float = 1e-7, atol: float = 0.0, **others: Any) -> None:
        allclose(actual, desired, rtol=rtol, atol=atol, **others)
        error, tolerance = np.abs(np.asarray(actual) - desired), atol + rtol * np.abs(np.asarray(desired))
        with np.errstate(all="ignore"):
            _note("allclose", float(np.nanmax(np.where(tolerance > 0.0, error / tolerance, 0.0), initial=0.0)))

    ApproxScalar.__eq__ = noted_eq
    vars(np.testing)["assert_allclose"] = noted_allclose


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    _running.append(item.nodeid)
    _margins[item.nodeid] = {}
    yield
    _running.pop()


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call() -> Iterator[None]:
    """Suppress explanations by line-by-line differences, which pytest would seek at length even if there are none."""
    explain, util._reprcompare = util._reprcompare, None
    yield
    util._reprcompare = explain


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note a failure; with several processes, the main process receives all reports."""
    if report.failed:
        _margins.setdefault(report.nodeid, {})["failed"] = 1.0


def pytest_assertion_pass(item: pytest.Item, lineno: int, orig: str, expl: str) -> None:
    """Note a comparison that held, from its explanation, as in `0.012 < (0.01 * 2.5)`."""
    ratio = _ratio(expl.split("\n", 1)[0])
    if ratio is not None:
        _margins.setdefault(item.nodeid, {})
        _note(f"line {lineno}", ratio)


def pytest_sessionfinish() -> None:
    """Write the notes of this process to a separate file in the folder `MARGINS_FOLDER`."""
    if _margins:
        Path(os.environ["MARGINS_FOLDER"], f"{uuid.uuid4()}.json").write_text(json.dumps(_margins), encoding="utf-8")


def _note(place: str, ratio: float) -> None:
    if not _running:
        return
    if not place.startswith("line"):
        place = f"{place} in {_line()}"
    margins = _margins.setdefault(_running[-1], {})
    margins[place] = max(margins.get(place, 0.0), ratio)


def _line() -> str:
    frame = sys._getframe(1)
    while frame.f_back is not None:
        file = Path(frame.f_code.co_filename)
        if TESTS in file.parents:
            return f"line {frame.f_lineno}"
        frame = frame.f_back
    return "a fixture"


def _ratio(explanation: str) -> float | None:
    """Return smaller over larger side of an inequality between positive numbers; None of anything else.

    Text is skipped: where pytest shortens it, a backslash may be cut from its letter, and Python would warn.
    """
    if "'" in explanation or '"' in explanation:
        return None
    try:
        tree = ast.parse(NUMPY_SCALAR.sub(r"\1", explanation), mode="eval").body
        if not isinstance(tree, ast.Compare) or len(tree.ops) != 1:
            return None
        left, right = _value(tree.left), _value(tree.comparators[0])
        if isinstance(tree.ops[0], ast.Gt | ast.GtE):
            left, right = right, left
        elif not isinstance(tree.ops[0], ast.Lt | ast.LtE):
            return None
        return left / right if left > 0.0 and right > 0.0 else None
    except (SyntaxError, ValueError, TypeError, ArithmeticError, RecursionError):
        return None


def _value(node: ast.expr) -> float:
    """Return the value of an expression of numbers; raises ValueError if it contains anything else."""
    allowed = (ast.BinOp, ast.UnaryOp, ast.Constant, ast.operator, ast.unaryop)
    if not all(isinstance(part, allowed) for part in ast.walk(node)):
        raise ValueError("not a number")
    return float(eval(compile(ast.Expression(node), "assertion", "eval")))
