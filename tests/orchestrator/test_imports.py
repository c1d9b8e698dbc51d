"""The files of the packages import each other without a circle."""

import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

PROJECT = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))


def test_no_circle_of_files_is_left():
    """Imports inside functions count, and so do those for types alone."""
    grimp = pytest.importorskip("grimp", reason="comes with import-linter (extra: dev)")
    packages = PROJECT["tool"]["importlinter"]["root_packages"]
    graph = grimp.build_graph(*packages, cache_dir=None)
    imported = {file: graph.find_modules_directly_imported_by(file) for file in graph.modules}
    assert len(imported) > 300
    TopologicalSorter(imported).prepare()  # a CycleError names the files of a circle
