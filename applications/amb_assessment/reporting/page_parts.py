"""Parts of self-contained pages: style, script, data and pictures inside the page, numbers as text."""

from __future__ import annotations

import base64
import json
from importlib.resources import files
from typing import Any

from markupsafe import Markup


def asset(name: str, package: str = "amb_assessment.reporting") -> Markup:
    """Return a file of a package's folder `template`, unchanged: a style or a script."""
    return Markup((files(package) / "template" / name).read_text(encoding="utf-8"))


def in_script(data: Any) -> Markup:
    """Return JSON escaped for a script element."""
    return Markup(json.dumps(data, allow_nan=False).replace("<", "\\u003c"))


def plotly_script() -> Markup:
    """Return plotly for a script element."""
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs().replace("</script", "<\\/script"))


def picture_url(picture: bytes) -> str:
    """Return a PNG picture as a data URL, empty without one."""
    return f"data:image/png;base64,{base64.b64encode(picture).decode('ascii')}" if picture else ""


def number_text(number: float) -> str:
    """Return a number with four significant digits, five above a thousand."""
    return f"{number:.5g}" if abs(number) >= 1000.0 else f"{number:.4g}"
