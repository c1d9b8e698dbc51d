"""Suggests close matches for a name that does not exist."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import SequenceMatcher

MOST_NEAR, MOST_LISTED = 5, 12
SIMILAR = 0.6  # least ratio of `SequenceMatcher` at which a name is close


def suggest(name: str, options: Iterable[str]) -> str:
    """Suggest the options closest to `name`; if none is close, list the `MOST_LISTED` nearest, or all if these are few.

    If none of these options has the prefix of `name` (such as `hub.` for `hub.unbalance`), options with this prefix are
    added. Case does not matter. The returned text is the second half of a message.

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
    matcher = SequenceMatcher()
    matcher.set_seq2(name.lower())  # about which the matcher keeps what it has computed
    similarity = {}
    for option in options:
        matcher.set_seq1(option.lower())
        similarity[option] = matcher.ratio()
    ranked = sorted(options, key=lambda option: -similarity[option])
    near = [o for o in ranked if similarity[o] >= SIMILAR] or [o for o in ranked if name.lower() in o.lower()]
    near = near[:MOST_NEAR]
    place = name.rpartition(".")[0].lower()
    here = [option for option in ranked if place and option.lower().startswith(f"{place}.")]
    if not set(near) & set(here):
        near += here[:MOST_NEAR]
    if near:
        return f"did you mean {', '.join(near)}?"
    if len(options) > MOST_LISTED:
        return f"there are {', '.join(ranked[:MOST_LISTED])} and {len(options) - MOST_LISTED} more"
    return f"there are {', '.join(options)}" if options else "there are none"
