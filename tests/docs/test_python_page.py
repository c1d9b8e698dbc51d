"""The reference page on Python: each parameter has the type and the default of the signature."""

import inspect
import sys
from importlib import import_module
from pathlib import Path

import pytest

pytest.importorskip("griffe", reason="renders the site (extra: docs)")
sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "mkdocs"))

import declarations
import griffe

pytestmark = pytest.mark.slow  # needs the extra docs

ROOT = Path(__file__).parents[2]

MODULES = ("amb_cosim", "amb_analysis.studies", "amb_cosim.cosim")
EXTENSION = str(ROOT / "docs" / "mkdocs" / "own_types.py")


@pytest.fixture(scope="module")
def documented():
    """The objects that the page shows, by their paths."""
    loader = griffe.GriffeLoader(
        extensions=griffe.load_extensions(EXTENSION),
        search_paths=[ROOT / name for name in ("orchestrator", "applications", "libraries", "fmus", "packs")],
        docstring_parser="numpy",
    )
    paths = [line.removeprefix("::: ") for module in MODULES for line in declarations.names_of(module)]
    items = {path: getattr(import_module(path.rpartition(".")[0]), path.rpartition(".")[2]) for path in paths}
    for package in {item.__module__.partition(".")[0] for item in items.values()} | {"amb_cosim"}:
        loader.load(package)
    loader.resolve_aliases()
    paths_of = {path: f"{item.__module__}.{item.__qualname__}" for path, item in items.items()}
    return {path: (item, loader.modules_collection[paths_of[path]]) for path, item in items.items()}


def _rows(shown):
    sections = [] if shown.docstring is None else shown.docstring.parse("numpy", warnings=False)
    return [row for section in sections if section.kind.value == "parameters" for row in section.value]


def test_each_parameter_has_the_type_and_default_of_its_signature(documented):
    rows, wrong = 0, []
    for path, (function, documentation) in documented.items():
        declared = inspect.signature(function).parameters
        for row in _rows(documentation):
            rows += 1
            local = declared[row.name]
            required = local.default is local.empty and local.kind not in (local.VAR_POSITIONAL, local.VAR_KEYWORD)
            if str(row.annotation) != str(local.annotation).strip("'\"") or (row.value is None) != required:
                wrong.append(f"{path}({row.name}: {row.annotation} = {row.value}), not {local}")
    assert rows > 200
    assert wrong == []
