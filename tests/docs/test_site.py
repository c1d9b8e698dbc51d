"""What the site renders: equations, and pages written from declarations."""

import logging
import re
import shutil
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

pytest.importorskip("mkdocs")
pytest.importorskip("latex2mathml")
sys.path.insert(0, str(Path(__file__).parents[2] / "docs" / "mkdocs"))

import declarations
import equations
import pathspec  # comes with mkdocs

from amb_cosim.cosim.system.system_tables import SystemTable
from amb_cosim.scenario.scenario import Scenario
from rotor_analysis.rotor import Rotor
from source_check.statements import Statements

pytestmark = pytest.mark.slow  # needs the extra docs

PAGE = (
    r'<p>speed <span class="arithmatex">\(\Omega &lt; 2\)</span></p><div class="arithmatex">\[a = b \tag{4.1}\]</div>'
)


def test_equations_become_mathml_with_their_numbers():
    html = equations.on_page_content(PAGE, "page")
    tree = ElementTree.fromstring(f"<main>{html}</main>")
    inline, block = tree.iter("{http://www.w3.org/1998/Math/MathML}math")
    assert "".join(inline.itertext()) == "Ω<2"
    assert "".join(block.itertext()) == "a=b"
    assert [span.text for span in tree.iter("span")] == ["(4.1)"]


@pytest.mark.parametrize("tex", [r"\nosuchcommand x", r"a & b", r"a^b^c"])
def test_an_equation_that_cannot_be_rendered_is_a_warning_of_mkdocs(tex, caplog):
    with caplog.at_level(logging.WARNING, logger="mkdocs"):
        equations.mathml(tex, True, "page.md")
    assert any(tex in record.getMessage() and "page.md" in record.getMessage() for record in caplog.records)


@pytest.fixture
def small_site(tmp_path):
    """A site of one page with theme, search and scripts of this project's."""
    pytest.importorskip("material")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    root = Path(__file__).parents[2]
    ours = yaml.safe_load((root / "mkdocs.yml").read_text(encoding="utf-8"))
    pages = tmp_path / "pages"
    for file in ours["extra"]["polyfills"]:
        (pages / file).parent.mkdir(parents=True)
        shutil.copy(root / file, pages / file)
    (pages / "index.md").write_text("# Pump\n\nA retainer catches it.\n", encoding="utf-8")
    settings = {"site_name": "small", "docs_dir": "pages", "theme": ours["theme"], "extra": ours["extra"]}
    plugins = [name for name in ours["plugins"] if name in ("offline", "search")]
    (tmp_path / "mkdocs.yml").write_text(yaml.safe_dump({**settings, "plugins": plugins}), encoding="utf-8")
    build(load_config(str(tmp_path / "mkdocs.yml")))
    return tmp_path / "site"


def test_a_page_opened_as_a_file_loads_all_its_scripts_from_files(small_site):
    """So that search works without a network: the index, and the worker that reads it, are files of the site."""
    page = (small_site / "index.html").read_text(encoding="utf-8")
    scripts = re.findall('<script src="([^"]*)"', page)
    assert len(scripts) >= 2
    assert [name for name in scripts if not (small_site / name).is_file()] == []
    assert "retainer" in (small_site / "search" / "search_index.js").read_text(encoding="utf-8")


def test_keys_of_a_file_have_units_limits_and_defaults():
    page = declarations.keys_of(Rotor)
    bearing = page[page.index("## `[[bodies]]` (Body)") :]
    assert "| `mass` | Mass. | number | kg | required | >= 0 |" in bearing
    assert "| `clearance` | Radial clearance. | number | m | `0.0005` | > 0 |" in page
    assert "| text |  | `timoshenko` | `timoshenko`, `rayleigh` |" in page
    assert "## `[materials.NAME]`" in page


@pytest.mark.parametrize("form", [Rotor, Scenario, SystemTable, Statements])
def test_every_key_of_a_file_has_a_description(form):
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \|", declarations.keys_of(form), re.MULTILINE)
    assert rows
    assert [key for key, meaning in rows if not meaning] == []


def test_templates_of_pages_are_no_pages():
    from pathspec.gitignore import GitIgnoreSpec

    root = Path(__file__).parents[2]
    lines = yaml.safe_load((root / "mkdocs.yml").read_text(encoding="utf-8"))["exclude_docs"].splitlines()
    templates = [path.relative_to(root) for path in (root / "applications").rglob("templates/*.md")]
    assert templates
    excluded = GitIgnoreSpec.from_lines(lines)
    assert all(excluded.match_file(path.as_posix()) for path in templates)
    assert not excluded.match_file("docs/index.md")


@pytest.mark.parametrize(
    ("name", "is_in_the_site"),
    [
        ("fmus/amb_actuator/README.md", True),
        ("orchestrator/amb_cosim/presentation/templates.py", True),
        ("fmus/amb_actuator/__pycache__/kernels/pull.nbi", False),
        ("applications/amb_assessment/first_design/templates/README.md", False),
        ("applications/amb_live/page/node_modules/tool/README.md", False),
        ("fmus/.cache/README.md", False),
        (".github/README.md", False),
    ],
)
def test_what_caches_and_templates_hold_is_no_page(name, is_in_the_site):
    """Kernels kept beside the sources differed each time that a release was made.

    Of pathspec's backends, `simple` includes these files if a pattern names only their folder.
    """
    patterns = yaml.safe_load((Path(__file__).parents[2] / "mkdocs.yml").read_text(encoding="utf-8"))["exclude_docs"]
    excluded = pathspec.GitIgnoreSpec.from_lines(patterns.splitlines(), backend="simple")
    assert excluded.match_file(name) != is_in_the_site
