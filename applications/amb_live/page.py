"""The live rig as one self-contained HTML page."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Iterable, Sequence
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from markupsafe import Markup

from amb_cosim.presentation.templates import templates_of
from amb_files.atomic import write_file
from amb_live.rig import Rig
from amb_live.scripts import joined

PAGE = "ui/main.js"
WORKER = "worker.js"


def write_page(rigs: Sequence[Rig], path: Path, documentation: str = "") -> Path:
    """Write the page atomically; see `page` for the arguments."""
    write_file(path, page(rigs, documentation))
    return path


def page(rigs: Sequence[Rig], documentation: str = "") -> str:
    """Return the text of the page.

    Parameters
    ----------
    rigs
        Scenarios of the page; the first is shown.
    documentation
        Relative or absolute address of the documentation's folder `docs`, for links to theory pages; by default there
        are no links.
    """
    environment = templates_of("amb_live", "page")
    sources = dict(_sources())
    return environment.get_template("live.html.j2").render(
        title=rigs[0].data["scenario"],
        style=_text("live.css"),
        uplot_style=_text("vendor/uplot/uPlot.min.css"),
        uplot=_script(_text("vendor/uplot/uPlot.iife.min.js")),
        script=_script(joined(PAGE, sources)),
        worker=_script(joined(WORKER, sources)),
        data=_json(_data(rigs, documentation)),
    )


def _data(rigs: Iterable[Rig], documentation: str) -> dict[str, Any]:
    """Return the compressed data of the page: every rig, and the parts that rigs share, each stored once."""
    rigs_data: list[dict[str, Any]] = []
    variables: dict[str, Any] = {}
    parts: dict[str, bytes] = {}
    for rig in rigs:
        components = []
        for component in rig.data["components"]:
            variables[component["guid"]] = component["variables"]
            components.append({**component, "variables": component["guid"]})
        rigs_data.append({**rig.data, "components": components})
        parts |= rig.parts
    content = {"documentation": documentation, "rigs": rigs_data, "variables": variables}
    text = json.dumps(content, allow_nan=False, separators=(",", ":"))
    return {"described": _packed(text.encode()), "parts": {key: _packed(part) for key, part in parts.items()}}


def _packed(content: bytes) -> str:
    """Return bytes in base64 after compression by gzip, which browsers can decompress; equal bytes give equal texts."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode("ascii")


def _sources() -> Iterable[tuple[str, str]]:
    """Yield path and text of each module of the page."""
    yield from _modules(files("amb_live") / "page", "")


def _modules(folder: Traversable, prefix: str) -> Iterable[tuple[str, str]]:
    for entry in folder.iterdir():
        if entry.is_dir() and entry.name not in ("node_modules", "vendor", "tests"):
            yield from _modules(entry, f"{prefix}{entry.name}/")
        elif entry.name.endswith(".js"):
            yield f"{prefix}{entry.name}", entry.read_text(encoding="utf-8")


def _text(name: str) -> Markup:
    return Markup((files("amb_live") / "page" / name).read_text(encoding="utf-8"))


def _script(text: str) -> Markup:
    """Return JavaScript escaped for a script element; escaped characters occur only in strings."""
    return Markup(text.replace("</script", "<\\/script").replace("<!--", "<\\!--"))


def _json(data: Any) -> Markup:
    """Return JSON escaped for a script element."""
    return Markup(json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c"))
