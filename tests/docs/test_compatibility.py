"""The page on compatibility says of each tool what its tests came to, and a failure before anything else."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from tools.compatibility.__main__ import COLUMNS, page
from tools.compatibility.record import version_of

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "compatibility.md"
pytest_plugins = ["pytester"]

TESTS = """
import pytest
as_master = pytest.mark.host("a master", "pytest", fmus="three", what="bits")
@as_master
@pytest.mark.parametrize("n", [1, 2])
def test_passes(n): pass
@pytest.mark.host("another", fmus="one", what="bits")
def test_is_skipped(): pytest.skip("it is not installed")
@pytest.mark.host("a third", fmus="one", what="bits", platform="Windows")
def test_fails(broken): pass
@pytest.fixture
def broken(): raise OSError
def test_of_no_host(): pass
"""


def row(text, tool):
    (line,) = [line for line in text.splitlines() if line.startswith(f"| {tool} |")]
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_outcomes_reasons_and_versions_come_from_the_run(pytester, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[2]))
    pytester.makeconftest(
        """
        def pytest_configure(config):
            from pathlib import Path
            from tools.compatibility.record import HostRecord
            config.addinivalue_line("markers", "host: as in the project")
            config.pluginmanager.register(HostRecord(Path("hosts.json")))
        """
    )
    pytester.makepyfile(TESTS)
    pytester.runpytest_subprocess("-p", "no:cacheprovider")
    record = json.loads((pytester.path / "hosts.json").read_text())
    assert len(record) == 4
    text = page(record)
    assert row(text, "a master")[1] == version_of("pytest") == pytest.__version__
    assert row(text, "a master")[3:] == ["three", "bits", "yes (2 tests)"]
    assert row(text, "another")[-1] == "not run; it is not installed"
    assert row(text, "a third")[2:] == ["Windows", "one", "bits", "**no**"]
    next(line for line in record.values() if line["tool"] == "a master")["outcome"] = "failed"
    assert row(page(record), "a master")[-1] == "**no**", "one of its tests failed"


def marked():
    """Tool and FMUs of every mark in the tests."""
    for file in PAGE.parents[2].glob("tests/*/test_*.py"):
        if file != Path(__file__):
            text = file.read_text(encoding="utf-8")
            yield from re.findall(r'in_host\(\s*"([^"]+)", "([^"]+)"', text)
            yield from re.findall(r'mark\.host\(\s*"([^"]+)".*?fmus="([^"]+)"', text, re.DOTALL)


def test_the_page_in_the_reference_has_every_host_that_tests_run_and_no_failure():
    lines = [line.strip("| ").split(" | ") for line in PAGE.read_text(encoding="utf-8").splitlines() if "|" in line]
    assert tuple(lines[0]) == COLUMNS
    rows = [dict(zip(COLUMNS, line, strict=True)) for line in lines[2:]]
    assert {(row["tool"], row["FMUs"]) for row in rows} == set(marked())
    assert {row["result"].partition(" (")[0] for row in rows} == {"yes"}
