"""Vague words are rare in names, comments and docstrings."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
VAGUE = ("found", "given", "told", "asked", "one", "there", "own", "known", "shown", "kept")
WORD = re.compile(rf"(?<![a-zA-Z])(?:{'|'.join(VAGUE)})(?![a-zA-Z])", re.IGNORECASE)  # parts of snake_case count
MOST = 20.0  # per 1,000 lines; python-control has 18, diffrax 6
FOREIGN = {"vendor", "fmi_headers", "node_modules", "__pycache__"}


def _sources(folder):
    files = (file for suffix in ("py", "js", "c", "h") for file in (ROOT / folder).rglob(f"*.{suffix}"))
    return [file for file in files if not FOREIGN & {*file.parts}]


@pytest.mark.parametrize("folder", ["orchestrator", "applications", "libraries", "fmus", "packs"])
def test_vague_words_are_rare(folder):
    texts = [file.read_text(encoding="utf-8") for file in _sources(folder)]
    lines, words = sum(text.count("\n") for text in texts), sum(len(WORD.findall(text)) for text in texts)
    assert words / lines <= MOST / 1000.0, f"{words} in {lines} lines"


def test_words_are_counted_within_names_but_not_within_longer_words():
    assert [match[0] for match in WORD.finditer("def own_path(found, known_f): drown, Known, phone")] == [
        *("own", "found", "known", "Known")
    ]
