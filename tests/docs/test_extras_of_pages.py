"""The README installs every extra that its pages and commands require."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


def within(extra: str) -> set[str]:
    """An extra, and those that it consists of."""
    inner = re.findall(r"amb-cosim\[(.*?)\]", " ".join(EXTRAS[extra]))
    return {extra}.union(*(within(name) for names in inner for name in names.split(",")))


def named(pattern: str, files: list[Path]) -> set[str]:
    return {name for file in files for name in re.findall(pattern, file.read_text(encoding="utf-8"))}


def installed() -> set[str]:
    (extra,) = re.findall(
        r"pip install '\.\[(\w+)\]' && amb-cosim run", (ROOT / "README.md").read_text(encoding="utf-8")
    )
    return within(extra)


def test_a_build_takes_the_compilers_that_the_extra_takes():
    """Machine code in a wheel and a user's own come from the same versions of ziglang."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    of_build = [item for item in project["build-system"]["requires"] if item.startswith("ziglang")]
    assert of_build == [item for item in EXTRAS["native"] if item.startswith("ziglang")]


def test_the_readme_installs_every_extra_that_a_command_requires():
    folders = ("orchestrator", "applications", "libraries", "fmus", "packs")
    required = named(
        r'(?:require|lacking)_extra\(\s*"(\w+)"', [file for folder in folders for file in (ROOT / folder).rglob("*.py")]
    )
    assert required >= {"native", "report", "sweep"}
    assert required <= installed()


def test_the_readme_installs_every_extra_that_a_page_names():
    pages = [*(ROOT / "docs/tutorials").glob("*.md"), *(ROOT / "docs/how-to").glob("*.md")]
    result = named(r"extra `(\w+)`", pages)
    assert result >= {"native", "report", "sweep"}
    assert result <= installed()
