"""What an FMU holds for people: a page about its model, sketch, licences, icon.

The page is the README of the model's package, whose table of variables gives way to that of the FMU, with the faults
and warnings of the model. It needs no network and no other file but the sketch.
"""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Iterable, Mapping
from html import escape

from fmi_export.building.identity import DOCUMENTATION, package_folder
from fmi_export.building.readme import BEGIN, DIGITS, END, full_description
from fmi_export.model import FAULT_NOT_FINITE, FAULT_RANGE, FAULT_STEP_SIZE, Model
from fmi_export.variables import LARGEST, Variable

PICTURES = {"sketch.svg": "documentation/sketch.svg", "icon.png": "model.png"}  # of a package, and where they go
HEADINGS = {"parameter": "Parameters", "input": "Inputs", "output": "Outputs"}
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
    """Return the files of an FMU's documentation by their paths in it, as far as its package has them.

    Parameters
    ----------
    model
        The model of the FMU.
    licences
        Other distributions whose code is in the FMU.
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
    """Return the text of the licence that an installed distribution has."""
    files = importlib.metadata.files(distribution) or []
    texts = [file.read_text(encoding="utf-8") for file in files if file.name.upper().startswith(("LICENSE", "LICENCE"))]
    return texts[0] if texts else f"{distribution} {importlib.metadata.version(distribution)}\n"


def page(model: Model) -> str:
    """Return the page of a model as HTML."""
    readme = package_folder(model.packages[0]) / "README.md"
    text = readme.read_text(encoding="utf-8") if readme.is_file() else f"# {model.name}\n\n{model.description}.\n"
    head, _, rest = text.partition(BEGIN)
    table = "\n".join(_variables(kind, model.interface.of(kind)) for kind in HEADINGS)  # type: ignore[arg-type]
    body = _html(head) + ("" if BEGIN in text else "<h2>Variables</h2>\n") + table + _html(rest.partition(END)[2])
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{escape(model.name)}</title>\n'
        f"<style>{STYLE}</style>\n</head>\n<body>\n{body}\n{_faults(model)}\n{_warnings(model)}\n</body>\n</html>\n"
    )


def _html(markdown: str) -> str:
    """Return Markdown as HTML; links to files that the FMU does not hold become their text."""
    from markdown_it import MarkdownIt  # takes as long to load as a build

    text = markdown.replace(f"({DOCUMENTATION}/", "(./")
    text = re.sub(r"!?\[([^\]]*)\]\((?!https?:|\./)[^)]*\)", r"\1", text)
    rendered: str = MarkdownIt("commonmark").enable("table").render(text)
    return rendered


def _table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """Return a table of cells that are HTML already."""
    lines = ["".join(f"<th>{cell}</th>" for cell in header)]
    lines += ["".join(f"<td>{cell}</td>" for cell in row) for row in rows]
    return "<table>\n" + "".join(f"<tr>{line}</tr>\n" for line in lines) + "</table>\n"


def _variables(kind: str, variables: Iterable[Variable]) -> str:
    header = ("name", "type", "unit", "start", "allowed", "description")
    return f"<h3>{HEADINGS[kind]}</h3>\n" + _table(header, (_cells(v) for v in variables))


def _cells(v: Variable) -> tuple[str, ...]:
    low = f"&ge; {v.literal(v.minimum, DIGITS)}" if v.minimum > -LARGEST else ""
    high = f"&le; {v.literal(v.maximum, DIGITS)}" if v.maximum < LARGEST else ""
    start = "" if v.causality == "output" else v.literal(v.start, DIGITS)
    allowed = ", ".join(bound for bound in (low, high) if bound)
    if v.enumeration:
        allowed, start = "", start and v.enumeration.names[int(v.start)]
    kind = ("tunable " if v.tunable else "") + ("Enumeration" if v.enumeration else v.type)
    unit = "" if v.unit == "1" else escape(v.unit)
    return f"<code>{escape(v.name)}</code>", kind, unit, start, allowed, escape(full_description(v))


def _faults(model: Model) -> str:
    own: Mapping[str, str] = {str(code): _sentence(sentence) for code, sentence in sorted(model.faults.items())}
    shared = {
        str(FAULT_STEP_SIZE): "step size not positive or not finite",
        f"{FAULT_RANGE} + r": "parameter or input with value reference r outside its range or not a number",
        f"{FAULT_NOT_FINITE} + r": "output with value reference r outside its range or not finite",
    }
    return "<h2>Faults</h2>\n" + _table(("fault_code", "meaning"), {**own, **shared}.items())


def _warnings(model: Model) -> str:
    told = [(f"<code>{v.name}</code>", _sentence(v.warning)) for v in model.interface.of("output") if v.warning]
    return "<h2>Warnings</h2>\n" + _table(("output", "logged when it becomes true"), told) if told else ""


def _sentence(sentence: str) -> str:
    """Return a sentence as HTML, with the names of the variables whose values it shows."""
    return re.sub(r"\{([^}]+)\}", r"<code>\1</code>", escape(sentence))
