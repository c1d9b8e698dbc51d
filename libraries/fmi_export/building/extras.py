"""Checks that the packages of an extra are installed."""

from __future__ import annotations

import json
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import urlparse
from urllib.request import url2pathname

DISTRIBUTION = "amb-cosim"


def require_extra(extra: str, purpose: str, *packages: str) -> None:
    """Check that these packages of an extra are installed.

    Raises
    ------
    ValueError
        If a package is missing; the message gives the command that installs the extra.
    """
    if lacking := lacking_extra(extra, purpose, *packages):
        raise ValueError(lacking)


def lacking_extra(extra: str, purpose: str, *packages: str) -> str:
    """Return which of these packages of an extra a purpose lacks, with the command that installs it; "" if none."""
    missing = [name for name in packages if find_spec(name) is None]
    return f"{purpose} needs {', '.join(missing)}, not installed: {install_command(extra)}" if missing else ""


def install_command(extra: str) -> str:
    """Return the command that installs an extra, from the clone if the package was installed from one (PEP 610)."""
    try:
        source = json.loads(distribution(DISTRIBUTION).read_text("direct_url.json") or "{}")
    except PackageNotFoundError:
        source = {}
    if "dir_info" not in source:
        return f"pip install '{DISTRIBUTION}[{extra}]'"
    clone = Path(url2pathname(urlparse(source["url"]).path))
    place = "." if clone == Path.cwd() else clone
    return f"pip install {'-e ' if source['dir_info'].get('editable') else ''}'{place}[{extra}]'"
