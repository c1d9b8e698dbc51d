"""Names and descriptions of variables in texts and figures."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import takewhile

PREPOSITIONS = ("at", "of", "in", "on", "to")
CODE = re.compile(r"[a-z]{1,2}\d+(\.[xy])?")  # such as p1.x


def name_label(name: str) -> str:
    """Return a name for readers: one or two letters with a number are capitalised, and other names are unchanged.

    Examples
    --------
    >>> name_label("w1"), name_label("p2.y"), name_label("ret_A"), name_label("left.x")
    ('W1', 'P2.Y', 'ret_A', 'left.x')
    """
    return name.upper() if CODE.fullmatch(name) else name


def common_words(descriptions: Sequence[str]) -> str:
    """Return the common first words of all descriptions, without a comma or preposition at the end.

    Examples
    --------
    >>> common_words(["Coefficient of friction at SEAL", "Coefficient of friction at SHROUD"])
    'Coefficient of friction'
    """
    at_each_place = zip(*(text.split() for text in descriptions), strict=False)  # as many as the shortest has
    words = [words[0] for words in takewhile(lambda words: len(set(words)) == 1, at_each_place)]
    return " ".join(words[:-1] if words and words[-1] in PREPOSITIONS else words).rstrip(",")
