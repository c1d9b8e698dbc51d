"""The files of the packages import each other without a circle."""

import re
import subprocess
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def test_no_circular_imports_exist():
    """Imports inside functions count, and so do those for types alone."""
    grimp = pytest.importorskip("grimp", reason="comes with import-linter (extra: dev)")
    packages = PROJECT["tool"]["importlinter"]["root_packages"]
    graph = grimp.build_graph(*packages, cache_dir=None)
    imported = {file: graph.find_modules_directly_imported_by(file) for file in graph.modules}
    assert len(imported) > 300
    TopologicalSorter(imported).prepare()  # a CycleError names the files of a circle


def test_the_table_of_allowed_imports_lists_every_folder():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.partition("Allowed imports")[2]
    folders = (*(ROOT / "applications").iterdir(), ROOT / "orchestrator" / "amb_cosim", ROOT / "libraries")
    rooms = {path.parent.name for folder in folders for path in folder.glob("*/__init__.py")}
    rooms -= {"figures"}  # of sweeps, beside what they show
    missing = sorted(room for room in rooms if not re.search(rf"[/`]{room}`", table))
    assert not missing


def test_the_orchestrator_imports_applications_only_in_its_facade():
    names = re.compile("|".join(sorted(path.name for path in (ROOT / "applications").iterdir() if path.is_dir())))
    files = (ROOT / "orchestrator").rglob("*.py")
    naming = {file.relative_to(ROOT).as_posix() for file in files if names.search(file.read_text(encoding="utf-8"))}
    assert naming == {"orchestrator/amb_cosim/__init__.py"}


def test_files_to_start_reading_at_exist():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text.partition("Where to start reading")[2].partition("Allowed imports")[0]
    files = re.findall(r"\]\(([^)#]+)\)", table)
    assert len(files) > 15
    assert [file for file in files if not (ROOT / file).is_file()] == []


TOP = """
.ci .clang-format .gitignore .pre-commit-config.yaml CHANGELOG.md CITATION.cff CONTRIBUTING.md LICENSE README.md
SECURITY.md applications benchmarks constraints.txt docs examples fmus hatch_build.py libraries mkdocs.yml orchestrator
packs pyproject.toml tests tools
"""


def test_repository_has_only_its_known_files_and_folders_at_the_top():
    """A folder of somebody's trial, `pasg`, was once committed."""
    if not (ROOT / ".git").exists():
        pytest.skip("needs a clone")
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert {path.partition("/")[0] for path in listed.splitlines()} == {*TOP.split()}
