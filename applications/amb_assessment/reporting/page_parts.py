"""Parts of self-contained pages: styles, scripts, data and pictures inside the page, and numbers as text."""

from __future__ import annotations

import base64
import json
from importlib.resources import files
from typing import Any

from markupsafe import Markup


def asset(name: str, package: str = "amb_assessment.reporting") -> Markup:
    """Return a style or a script from a package's folder `template`, unchanged."""
    return Markup((files(package) / "template" / name).read_text(encoding="utf-8"))


def in_script(data: Any) -> Markup:
    """Return data as JSON that is escaped for a script element."""
    return Markup(json.dumps(data, allow_nan=False).replace("<", "\\u003c"))


def plotly_script() -> Markup:
    """Return the Plotly library, escaped for a script element."""
    from plotly.offline import get_plotlyjs

    return Markup(get_plotlyjs().replace("</script", "<\\/script"))


def picture_url(picture: bytes) -> str:
    """Return a PNG picture as a data URL, or an empty text if there is no picture."""
    return f"data:image/png;base64,{base64.b64encode(picture).decode('ascii')}" if picture else ""


def number_text(number: float) -> str:
    """Return a number as text with four significant digits, or with five if it is 1000 or more."""
    return f"{number:.5g}" if abs(number) >= 1000.0 else f"{number:.4g}"
