"""Pages, docstrings and messages are spelt right and written plainly; prose.toml has rules and exceptions."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from fnmatch import fnmatch
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import pytest
from prose import CODE, Passage, passages_of

WORDS = re.compile(r"[A-Za-z]{2,}")
VALUE = "{}"  # in place of a value in a message


@cache
def passages_of_source(file: Path) -> tuple[Passage, ...]:
    """Return docstrings, and strings of three words or more, with their lines; comments are not checked."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    parts = {part for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in node.values}
    return tuple(
        Passage("p", node.lineno, " ".join(paragraph.split()))
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant | ast.JoinedStr) and node not in parts
        for paragraph in re.split(r"\n\s*\n|\n\s*-{3,}\n", _text(node))
        if len(WORDS.findall(paragraph)) >= 3 and " " in paragraph.strip()
    )


def _text(node: ast.Constant | ast.JoinedStr) -> str:
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else ""
    return "".join(str(part.value) if isinstance(part, ast.Constant) else VALUE for part in node.values)


ROOT = Path(__file__).parents[2]
RULES = tomllib.loads(Path(__file__).with_name("prose.toml").read_text(encoding="utf-8"))
PLAIN = {re.compile(pattern): plain for pattern, plain in RULES["plain"].items()}
ROOMS = (
    "docs",
    "fmus",
    "libraries",
    "orchestrator",
    "applications",
    "packs",
    "examples",
    "benchmarks",
    "tests",
    "tools",
)
LEFT_OUT = {"node_modules", "__pycache__", "vendor", "iframe-worker", "fmi_headers"}
FOUND = re.compile(r"^(?P<file>.*?):(?P<line>\d+):\d+: (?P<check>[\w.]+): (?P<message>.*)$", re.MULTILINE)


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def files(*suffixes: str) -> list[Path]:
    inner = [file for room in ROOMS for file in (ROOT / room).rglob("*") if not LEFT_OUT & {*file.parts}]
    return sorted(file for file in [*ROOT.glob("*"), *inner] if file.suffix in suffixes and file.is_file())


PAGES = [page for page in files(".md") if not any(fnmatch(name_of(page), form) for form in RULES["unchecked"])]


PACKAGES = [
    package
    for folder in (
        "fmus",
        "libraries",
        "orchestrator/amb_cosim",
        "applications/amb_analysis",
        "applications/amb_assessment",
        "applications",
        "packs",
    )
    for package in sorted((ROOT / folder).iterdir())
    if package.is_dir() or package.suffix == ".py"
]


def faults(passage: Passage) -> list[str]:
    """Return the faults of style in a passage, each with its sentence."""
    result = []
    for sentence in passage.sentences:
        is_sentence = passage.kind == "p" and sentence.endswith(".")
        words = max(len(part.split()) for part in re.split(r"[:;] ", sentence))
        if is_sentence and words > RULES["longest_sentence"]:
            result.append(f"{words} words without a stop: {sentence}")
        for pattern, plain in PLAIN.items():
            if pattern.search(sentence) and (is_sentence or not pattern.pattern.startswith("^")):
                result.append(f"write {plain!r}: {sentence}")
    return result


def allowed(page: str, fault: str) -> bool:
    return any(page == entry["page"] and entry["text"] in fault for entry in RULES.get("allowed", []))


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_page_is_written_plainly(page):
    reported = [f"line {passage.line}: {fault}" for passage in passages_of(page) for fault in faults(passage)]
    assert "\n".join(fault for fault in reported if not allowed(name_of(page), fault)) == ""


def number_of_words(texts: Iterable[str]) -> int:
    return len(re.findall(r"[A-Za-z][A-Za-z'-]*", "\n".join(texts).replace(CODE, "code")))


def per_thousand_words(pattern: str, texts: list[str]) -> float:
    return 1000.0 * len(re.findall(pattern, "\n".join(texts))) / number_of_words(texts)


def test_each_page_answers_one_question():
    """A longer page is two pages; tables and terms of the reference are looked up, not read."""
    pages = [page for page in PAGES if name_of(page).startswith("docs/") and "reference" not in page.parts]
    words = {name_of(page): number_of_words(passage.text for passage in passages_of(page)) for page in pages}
    assert {name: count for name, count in words.items() if count > RULES["longest_page"]} == {}


@pytest.mark.parametrize("measure", [name for name in RULES["rhythm"] if name != "left_out"])
def test_pages_are_connected_prose_for_a_reader(measure):
    """Compressed prose has colons in place of connectives, numbers in place of tables, and does not address you."""
    pages = [ROOT / "README.md", *(page for page in PAGES if name_of(page).startswith("docs/"))]
    left_out = RULES["rhythm"]["left_out"]
    chosen = [page for page in pages if not any(fnmatch(name_of(page), form) for form in left_out)]
    texts = [passage.text for page in chosen for passage in passages_of(page) if passage.kind == "p"]
    limits = RULES["rhythm"][measure]
    assert limits.get("least", 0.0) <= per_thousand_words(limits["pattern"], texts) <= limits.get("most", 1000.0)


def test_compressed_prose_is_refused():
    compressed = ["Three numbers suffice: mass 60 kg, length 1.2 m, speed 12000 rpm; those of a drawing, in its file."]
    connected = ["You can start from mass, length and speed. However, if you have a drawing, start from its file."]
    for name, limits in RULES["rhythm"].items():
        if name != "left_out":
            allowed = [
                limits.get("least", 0.0) <= per_thousand_words(limits["pattern"], texts) <= limits.get("most", 1000.0)
                for texts in (compressed, connected)
            ]
            assert allowed == [False, True], name


def test_each_entry_of_the_changelog_is_complete_and_occurs_once():
    """A merge can keep both versions of an entry, or the first line of one."""
    entries = re.findall(r"^- .*(?:\n  .*)*", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert [entry for entry, count in Counter(entries).items() if count > 1] == []
    assert [entry for entry in entries if not entry.endswith((".", ":", ")"))] == []


def test_each_change_of_the_next_release_is_one_line_and_highlights_are_few():
    page = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    newest = re.split(r"^## ", page, flags=re.MULTILINE)[1]
    shown = re.sub(r"\]\([^)]*\)", "", newest).splitlines()
    assert [line for line in shown if line.startswith("  ") or (line.startswith("- ") and len(line) > 150)] == []
    assert len(re.findall(r"^- ", newest.partition("###")[0], re.MULTILINE)) <= 10


def translated(passage: Passage) -> list[str]:
    """Return the sentences of a docstring or message that have a pattern of translated prose."""
    return [
        f"line {passage.line}: write {plain!r}: {sentence}"
        for sentence in passage.sentences
        for pattern, plain in PLAIN.items()
        if pattern.search(sentence)
    ]


@pytest.mark.parametrize("package", PACKAGES, ids=name_of)
def test_docstrings_and_messages_are_written_plainly(package):
    sources = sorted(package.rglob("*.py")) if package.is_dir() else [package]
    reported = [
        f"{name_of(source)}, {fault}"
        for source in sources
        for passage in passages_of_source(source)
        for fault in translated(passage)
    ]
    assert "\n".join(reported) == ""


def texts_of(data: object) -> Iterator[str]:
    """Yield the strings of three words or more in the data of a TOML file."""
    if isinstance(data, str) and len(WORDS.findall(data)) >= 3:
        yield data
    elif isinstance(data, dict | list):
        for part in data.values() if isinstance(data, dict) else data:
            yield from texts_of(part)


def test_texts_of_packs_systems_and_criteria_are_written_plainly():
    reported = [
        f"{name_of(file)}: {fault}"
        for room in ("packs", "orchestrator", "applications", "examples")
        for file in (ROOT / room).rglob("*.toml")
        if not file.parent.name.endswith("templates")
        for text in texts_of(tomllib.loads(file.read_text(encoding="utf-8")))
        for fault in faults(Passage("p", 0, f"{text.rstrip('.')}."))
    ]
    assert "\n".join(reported) == ""


def test_faults_of_docstrings_and_messages_are_refused(tmp_path):
    source = tmp_path / "texts.py"
    source.write_text(
        '"""What takes longest is to type it."""\n\nMESSAGE = "the force hangs on the angle"  # told\n'
        'NAMES = ["told", f"{MESSAGE} is not told here"]\n',
        encoding="utf-8",
    )
    lines = [fault.split(":")[0] for passage in passages_of_source(source) for fault in translated(passage)]
    assert sorted(lines) == ["line 1", "line 3", "line 4"]


def test_every_exception_is_needed(style_faults):
    for entry in RULES.get("allowed", []):
        assert entry["reason"]
        reported = [fault for passage in passages_of(ROOT / entry["page"]) for fault in faults(passage)]
        assert any(entry["text"] in fault for fault in [*reported, *style_faults[0][entry["page"]]]), entry["text"]


@pytest.mark.parametrize("sentence", RULES["refused"])
def test_translated_prose_is_refused(sentence):
    assert faults(Passage("p", 1, sentence))


def test_long_sentences_are_refused_and_short_ones_are_not():
    assert faults(Passage("p", 1, "The " + "very " * RULES["longest_sentence"] + "long rotor turns."))
    assert faults(Passage("p", 1, "The impact force depends on the rotor angle at release.")) == []


@pytest.fixture(scope="module")
def style_faults(tmp_path_factory):
    """What proselint finds, by page: each page as a text of its passages, on the lines that they have there."""
    if find_spec("proselint") is None:
        pytest.skip("proselint is not installed (extra: dev)")
    folder, texts = tmp_path_factory.mktemp("prose"), []
    for number, page in enumerate(PAGES):
        lines: dict[int, str] = defaultdict(str)
        for passage in passages_of(page):
            lines[passage.line] += passage.text.replace(CODE, "it") + ". "
        texts.append([lines[line] for line in range(1, max(lines, default=0) + 1)])
        (folder / f"{number}.md").write_text("\n".join(texts[number]), encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "proselint", "--output-format", "compact", "check", str(folder)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    result = defaultdict(list)
    for match in FOUND.finditer(f"{done.stdout}\n{done.stderr}"):
        if not match["check"].startswith(tuple(RULES["proselint"]["disabled"])):
            number, line = int(Path(match["file"]).stem), int(match["line"])
            fault = f"line {line}: {match['check']}: {match['message']} {texts[number][line - 1]}"
            result[name_of(PAGES[number])].append(fault)
    return result, done


def test_proselint_finds_nothing(style_faults):
    result, _ = style_faults
    assert [(page, fault) for page, of in result.items() for fault in of if not allowed(page, fault)] == []


def test_proselint_ran(style_faults):
    """It finds the straight quotes, which are disabled, so it has read the pages."""
    _, done = style_faults
    assert FOUND.search(f"{done.stdout}\n{done.stderr}"), done


def spelling(*paths: str) -> subprocess.CompletedProcess[str]:
    if find_spec("codespell_lib") is None:
        pytest.skip("codespell is not installed (extra: dev)")
    words = ",".join(RULES["spelling"]["allowed"])
    command = [sys.executable, "-m", "codespell_lib", f"--ignore-words-list={words}", *paths]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def test_pages_and_sources_are_spelt_correctly():
    sources = map(name_of, files(".md", ".py", ".toml", ".j2", ".c", ".h", ".js", ".yml"))
    done = spelling(*(file for file in sources if not file.startswith("tests/")))  # which misspell names on purpose
    assert (done.stdout, done.returncode) == ("", 0), done.stderr


def test_pages_state_speeds_of_machines_in_rpm():
    """Pages of theory and reference may have angular frequencies, and three pages list units of variables and files."""
    lists = {"measured.md", "swap_a_component.md", "notebook.md"}
    of_theory = {"theory", "reference"}
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    read = [page for page in pages if not {*page.relative_to(ROOT).parts} & of_theory and page.name not in lists]
    assert len(read) > 40
    found = [
        f"{name_of(page)}: {line}"
        for page in read
        for line in page.read_text(encoding="utf-8").splitlines()
        if re.search(r"\d rad/s\b|\(rad/s\)", line)
    ]
    assert found == []


def test_misspelt_words_are_refused(tmp_path):
    (tmp_path / "page.md").write_text("The rotor touchs its retainer and recieves a force.\n", encoding="utf-8")
    assert "recieves ==> receives" in spelling(str(tmp_path / "page.md")).stdout
