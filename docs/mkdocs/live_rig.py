"""MkDocs hook: writes the live rig beside the page that describes it, and a link there, unless the site is served."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

DESCRIBED = "docs/how-to/live.md"
RIG = "rig.html"
LINK = f'\n\n<p><a class="md-button md-button--primary" href="{RIG}">Open the live rig</a></p>\n\n'
commands: list[str] = []


def on_startup(command: Literal["build", "gh-deploy", "serve"], **_: Any) -> None:
    """Remember whether the site is built or served."""
    commands[:] = [command]


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Return the page that describes the rig with a link to it below its title."""
    if page.file.src_uri != DESCRIBED or commands == ["serve"]:
        return markdown
    title, _, text = markdown.partition("\n\n")
    return f"{title}{LINK}{text}"


def on_post_build(config: Any, **_: Any) -> None:
    """Write the rig into the site."""
    if commands == ["serve"]:
        return
    from amb_live.choice import rigs_of
    from amb_live.page import write_page

    write_page(rigs_of(), Path(config["site_dir"]) / Path(DESCRIBED).with_name(RIG), documentation="..")
