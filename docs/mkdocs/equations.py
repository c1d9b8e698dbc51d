"""MkDocs hook: renders TeX between $ and $$ to MathML when the site is built, with a font that the site carries.

Browsers show MathML without a script and without a network. What cannot be rendered is a warning, which fails a strict
build.
"""

from __future__ import annotations

import logging
import re
from html import unescape
from importlib import resources

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

FONT = "STIXTwoMath-Regular.ttf"
STYLE = """
@font-face { font-family: "STIX Two Math"; src: url("STIXTwoMath-Regular.ttf"); }
math { font-family: "STIX Two Math", math; }
mover > mo:last-child { font-size: 1.25em; }
mtd[columnalign="left"] { text-align: left; }
mtd[columnalign="right"] { text-align: right; }
mtable[columnspacing^="0em"] mtd { padding-left: 0; padding-right: 0; }
.equation { display: flex; align-items: center; overflow-x: auto; overflow-y: hidden; margin: 1em 0; font-size: 1.1em; }
.equation math { flex: 1; margin: 0; }
"""
EQUATION = re.compile(r'<(div|span) class="arithmatex">\\[\[(](.*?)\\[\])]</\1>', re.DOTALL)
TAG = re.compile(r"\\tag\{(.*?)\}")
NOT_RENDERED = re.compile(r"<m[io]>(\\\w+|&)</m[io]>")
SPELLINGS = {"{aligned}": "{align*}", r"\lvert": r"\left|", r"\rvert": r"\right|"}  # in the words of latex2mathml

log = logging.getLogger("mkdocs.equations")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the font and the style of equations to the site."""
    font = resources.files("ziamath").joinpath("fonts", FONT).read_bytes()
    files.append(File.generated(config, f"assets/math/{FONT}", content=font))
    files.append(File.generated(config, "assets/math/equations.css", content=STYLE))
    return files


def on_page_content(html: str, page: object, **_: object) -> str:
    """Return the page with MathML in place of TeX."""
    return EQUATION.sub(lambda found: mathml(unescape(found[2]), found[1] == "div", str(page)), html)


def mathml(tex: str, display: bool, where: str = "") -> str:
    """Return the MathML of an equation; on a line of its own, if `display`, with the number that its `tag` gives it."""
    numbers = TAG.findall(tex)
    plain = TAG.sub("", tex)
    for theirs, ours in SPELLINGS.items():
        plain = plain.replace(theirs, ours)
    try:
        rendered = convert(plain, display="block" if display else "inline")
    except Exception as error:  # of any kind, by TeX that it does not know
        log.warning("%s: equation %r cannot be rendered: %r", where, tex, error)
        return f"<code>{tex}</code>"
    for unknown in NOT_RENDERED.findall(rendered):
        log.warning("%s: equation %r has %r, which cannot be rendered", where, tex, unknown)
    if not display:
        return rendered
    number = "".join(f"<span>({text})</span>" for text in numbers)
    return f'<div class="equation">{rendered}{number}</div>'
