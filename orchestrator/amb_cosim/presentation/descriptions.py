"""Descriptions of variables in the texts of figures."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import takewhile

PREPOSITIONS = ("at", "of", "in", "on", "to")


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
