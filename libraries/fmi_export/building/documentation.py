"""Documentation in an FMU: a page about its model, a sketch, licences and an icon.

The page contains the README of the model's package, followed by the FMU's variables, faults and warnings. A section of
the README that shows an example names its variables in a comment, and is only on the pages of FMUs that have these. The
page needs neither a network nor any other file except the sketch.
"""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Iterable
from html import escape

from fmi_export.building.identity import DOCUMENTATION, package_folder
from fmi_export.building.interface_page import PageTable, tables
from fmi_export.model import Model

PICTURES = {"sketch.svg": "documentation/sketch.svg", "icon.png": "model.png"}  # of a package, and where they go
EXAMPLE_OF = re.compile(r"<!-- variables: (.+) -->\n+")
STYLE = """
body { font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; font-size: 14px; }
th, td { border: 1px solid #ccc; padding: 0.2em 0.6em; text-align: left; vertical-align: top; }
th { background: #eef2f6; }
code, pre { font-family: monospace; font-size: 14px; }
pre { background: #f6f8fa; padding: 0.8em; overflow-x: auto; line-height: 1.3; }
img { max-width: 100%; }
"""


def documentation(model: Model, licences: Iterable[str] = ()) -> dict[str, bytes]:
    """Return the documentation files of an FMU by their paths in it, with pictures if the model's package has any.

    Parameters
    ----------
    model
        The model of the FMU.
    licences
        Names of other distributions whose code is in the FMU.
    """
    folder = package_folder(model.packages[0])
    files = {
        target: (folder / DOCUMENTATION / name).read_bytes()
        for name, target in PICTURES.items()
        if (folder / DOCUMENTATION / name).is_file()
    }
    files["documentation/index.html"] = page(model).encode()
    files["documentation/licenses/license.txt"] = licence("amb-cosim").encode()
    for name in licences:
        files[f"documentation/licenses/{name}.txt"] = licence(name).encode()
    return files


def licence(distribution: str) -> str:
    """Return the licence text of an installed distribution."""
    files = importlib.metadata.files(distribution) or []
    texts = [file.read_text(encoding="utf-8") for file in files if file.name.upper().startswith(("LICENSE", "LICENCE"))]
    return texts[0] if texts else f"{distribution} {importlib.metadata.version(distribution)}\n"


def page(model: Model) -> str:
    """Return the page of a model as HTML."""
    readme = package_folder(model.packages[0]) / "README.md"
    text = (
        _for_model(readme.read_text(encoding="utf-8"), model)
        if readme.is_file()
        else f"# {model.name}\n\n{model.description}.\n"
    )
    html_tables = "\n".join(_table(table) for table in tables(model))
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(model.name)}</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n{_html(text)}\n{html_tables}\n</body>\n</html>\n"
    )


def _for_model(readme: str, model: Model) -> str:
    """Return a README without the sections whose examples use variables that the model lacks."""
    sections = [(EXAMPLE_OF.search(section), section) for section in re.split(r"^(?=## )", readme, flags=re.MULTILINE)]
    return "".join(
        EXAMPLE_OF.sub("", section)
        for example, section in sections
        if example is None or set(example[1].split(", ")) <= model.interface.position.keys()
    )


def _html(markdown: str) -> str:
    """Convert Markdown to HTML; links to files outside the FMU are replaced by their text."""
    from markdown_it import MarkdownIt  # takes as long to load as a build

    text = markdown.replace(f"({DOCUMENTATION}/", "(./")
    text = re.sub(r"!?\[([^\]]*)\]\((?!https?:|\./)[^)]*\)", r"\1", text)
    rendered: str = MarkdownIt("commonmark").enable("table").render(text)
    return rendered


def _table(table: PageTable) -> str:
    lines = ["".join(f"<th>{cell}</th>" for cell in table.header)]
    lines += ["".join(f"<td>{_cell(cell)}</td>" for cell in row) for row in table.rows]
    rows = "".join(f"<tr>{line}</tr>\n" for line in lines)
    return f"<h2>{table.title}</h2>\n<table>\n{rows}</table>\n"


def _cell(cell: str) -> str:
    return re.sub(r"`([^`]*)`", lambda code: f"<code>{code[1]}</code>", escape(cell))
