"""What this package does with an extra alone, said where that is missing."""

from __future__ import annotations

from importlib.util import find_spec


def require_extra(extra: str, purpose: str, *packages: str) -> None:
    """Check that packages are installed which an extra brings and a plain run does not need.

    Raises
    ------
    ValueError
        If one is missing, with the command that installs the extra.
    """
    missing = [name for name in packages if find_spec(name) is None]
    if missing:
        raise ValueError(f"{purpose} needs {', '.join(missing)}, not installed: pip install 'amb-cosim[{extra}]'")
