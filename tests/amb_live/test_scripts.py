"""The scripts of the page pass their unit tests, type checks and linter."""

from pathlib import Path

import pytest
from command_line import run_program

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "applications" / "amb_live" / "page"
TOOLS = PAGE / "node_modules" / ".bin"


def passes(*command: str, cwd: Path = PAGE) -> None:
    run_program(*command, cwd=cwd)


@pytest.mark.parametrize("file", sorted((HERE / "unit").glob("*.mjs")), ids=lambda file: file.name.partition(".")[0])
def test_unit_tests_of_the_scripts_pass(node, file):
    passes(node, "--test", str(file))


@pytest.mark.parametrize("tool", ["tsc", "eslint"])
def test_types_and_style_of_the_scripts_are_right(node, tool):
    if not (TOOLS / tool).exists():
        pytest.skip(f"{tool} is not installed: npm ci in {PAGE.relative_to(HERE.parents[1])}")
    passes(str(TOOLS / tool), *(["."] if tool == "eslint" else []))


def test_lock_file_contains_no_download_address():
    assert '"resolved"' not in (PAGE / "package-lock.json").read_text(encoding="utf-8")
