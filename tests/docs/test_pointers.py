"""Files and names that texts point to exist: pages, docstrings and comments."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[2]
TEXTS, CODE = (".md", ".py", ".toml", ".c", ".h", ".js", ".mjs", ".j2"), (".py", ".c", ".h", ".js", ".mjs")
LEFT_OUT = {"node_modules", "__pycache__", "vendor", "fmi_headers"}
OUTPUT = ("site", "results", "build", "dist")  # folders at the top
HISTORY = ("CHANGELOG.md", "docs/reference/removed.md")  # point to what was there
PATH = re.compile(r"`([\w.-]+(?:/[\w.-]+)+\.\w+)`")
NAME = re.compile(
    r"`((?:amb_\w+|fmi_export|rotor_analysis|signal_chain|source_check|benchmarks|tools)(?:\.\w+)+)(?<!\.py)`"
)
LINK = re.compile(r"\]\((?!\w+:)([^)\s#]*)(?:#([^)\s]+))?\)")
HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)
CODE_BLOCK = re.compile(r"```.*?```", re.DOTALL)
FORMS = ("amb_cosim.studies.NAME", "amb_cosim.applications", "amb_cosim.models", "amb_cosim.packs")  # entry points


def _files() -> list[Path]:
    folders = [
        path for path in ROOT.iterdir() if path.name not in OUTPUT and (path.name[0] != "." or path.name == ".ci")
    ]
    files = (file for folder in folders for file in (folder.rglob("*") if folder.is_dir() else (folder,)))
    return [file for file in files if file.is_file() and not LEFT_OUT & {*file.relative_to(ROOT).parts}]


def _pointers(pattern: re.Pattern[str]) -> Iterator[tuple[str, str]]:
    """Yield each text's file with what it points to."""
    for file in _files():
        name = file.relative_to(ROOT).as_posix()
        if file.suffix in TEXTS and name not in HISTORY:
            for target in pattern.findall(file.read_text(encoding="utf-8", errors="replace")):
                yield name, target


def _exists(name: str) -> bool:
    """Whether a dotted name is a module, or an attribute or a field of one."""
    parts = name.split(".")
    for length in range(len(parts), 0, -1):
        try:
            target = import_module(".".join(parts[:length]))
        except ImportError:
            continue
        for attribute in parts[length:]:
            if attribute in getattr(target, "__annotations__", {}):
                return True
            target = getattr(target, attribute, None)
        return target is not None
    return False


def test_source_files_named_in_texts_exist():
    ends = {"/" + file.relative_to(ROOT).as_posix() for file in _files()}
    pointers = [(file, path) for file, path in _pointers(PATH) if path.endswith(CODE)]
    assert len(pointers) > 20
    assert [(file, path) for file, path in pointers if not any(end.endswith("/" + path) for end in ends)] == []


def test_dotted_names_in_texts_exist():
    pointers = {(file, name) for file, name in _pointers(NAME) if name not in FORMS}
    assert len(pointers) > 50
    exists = {name: _exists(name) for name in {name for _, name in pointers}}
    assert sorted((file, name) for file, name in pointers if not exists[name]) == []


def _anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page."""
    headings = HEADING.findall(CODE_BLOCK.sub("", page.read_text(encoding="utf-8")))
    shown = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading) for heading in headings)
    return {re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower()) for heading in shown}


def test_links_between_pages_lead_to_files_and_headings():
    pages = [file for file in _files() if file.suffix == ".md"]
    links = [(page, *link) for page in pages for link in LINK.findall(CODE_BLOCK.sub("", page.read_text("utf-8")))]
    missing = []
    for page, target, anchor in links:
        aim = (page.parent / target).resolve() if target else page
        if not aim.exists() or (anchor and aim.suffix == ".md" and re.sub(r"_\d+$", "", anchor) not in _anchors(aim)):
            missing.append((page.relative_to(ROOT).as_posix(), target, anchor))
    assert len(links) > 500
    assert missing == []
