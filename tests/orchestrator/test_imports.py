"""The files of the packages import each other without a circle."""

import re
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import amb_cosim

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))


def test_no_circle_of_files_is_left():
    """Imports inside functions count, and so do those for types alone."""
    grimp = pytest.importorskip("grimp", reason="comes with import-linter (extra: dev)")
    packages = PROJECT["tool"]["importlinter"]["root_packages"]
    graph = grimp.build_graph(*packages, cache_dir=None)
    imported = {file: graph.find_modules_directly_imported_by(file) for file in graph.modules}
    assert len(imported) > 300
    TopologicalSorter(imported).prepare()  # a CycleError names the files of a circle


def test_the_table_of_allowed_imports_has_every_room():
    text = (Path(__file__).parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.partition("Allowed imports")[2]
    rooms = {path.parent.name for path in Path(amb_cosim.__file__).parent.glob("*/__init__.py")}
    missing = sorted(room for room in rooms if f"/{room}`" not in table)
    assert not missing


def test_files_to_start_reading_at_exist():
    root = Path(__file__).parents[2]
    text = (root / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.partition("Where to start reading")[2].partition("Allowed imports")[0]
    files = re.findall(r"\]\(([^)#]+)\)", table)
    assert len(files) > 15
    assert [file for file in files if not (root / file).is_file()] == []
