"""Suggests close matches for a name that does not exist."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST_LISTED = 12


def suggest(name: str, options: Iterable[str]) -> str:
    """Suggest the options closest to `name`; if none is close, list the first `MOST_LISTED` options.

    If none of these options has the prefix of `name` (such as `hub.` for `hub.unbalance`), options with this prefix are
    added. The returned text is the second half of a message.

    Examples
    --------
    >>> suggest("clearence", ["clearance", "stiffness"])
    'did you mean clearance?'
    >>> suggest("x", ["a", "b", "c"])
    'there are a, b, c'
    >>> suggest("hub.unbalance", ["hub.u", "hub.phi", "energy.balance"])
    'did you mean hub.u, hub.phi?'
    """
    options = list(dict.fromkeys(options))
    near = difflib.get_close_matches(name, options, n=5) or [o for o in options if name in o][:5]
    place = name.rpartition(".")[0]
    here = [option for option in options if place and option.startswith(f"{place}.")]
    if not set(near) & set(here):
        near = [*near, *here[:5]]
    if near:
        return f"did you mean {', '.join(near)}?"
    rest = f" and {len(options) - MOST_LISTED} more" if len(options) > MOST_LISTED else ""
    return f"there are {', '.join(options[:MOST_LISTED])}{rest}" if options else "there are none"
