"""Tests of messages: which facts a message names. Its words can change; its names, values, units and limits cannot."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest


def assert_names(message: object, *facts: str) -> None:
    """Fail unless the message (text, exception or `ExceptionInfo`) has every fact, as whole words, in any order.

    A fact that is part of another one must occur beside it: `0 N` and `> 0 N` need "force = 0 N must be > 0 N".

    White space counts as one space. A name does not match within a longer one (`mb1.x` in `mb1.xx` or
    `rotor.mb1.x`), nor a number within another (`1` in `15`, `-1`, `0.1`, `1e+12`), nor a unit in a longer one.
    """
    __tracebackhide__ = True
    if not facts or not all(fact.strip() for fact in facts):
        raise ValueError(f"facts = {facts} is not allowed; each must be a text that the message names")
    text = _line(message.value if isinstance(message, pytest.ExceptionInfo) else message)
    if missing := [fact for fact in facts if _count(fact, text) < sum(_count(fact, other) for other in facts)]:
        pytest.fail(f"the message does not name {', '.join(map(repr, missing))}:\n{text}")


@contextmanager
def raises_naming(expected: type[BaseException], *facts: str) -> Iterator[pytest.ExceptionInfo[BaseException]]:
    """Do as `pytest.raises(expected)`, and assert that the error names the facts."""
    __tracebackhide__ = True
    with pytest.raises(expected) as error:
        yield error
    assert_names(error, *facts)


def _line(text: object) -> str:
    return " ".join(str(text).split())


def _count(fact: str, text: str) -> int:
    """Return how often the text has the fact as whole words."""
    fact, text = _line(fact), _line(text)
    before, after = "", ""
    if fact[0].isdigit():
        before = r"(?<![\w.+-])"
    elif fact[0].isalpha() or fact[0] == "_":
        before = r"(?<!\w)(?<!\w\.)"
    elif fact[0] in "+-":
        before = r"(?<![\w-])"
    if fact[-1].isalnum() or fact[-1] == "_":
        after = r"(?!\w|\.\w|/\w)"
    return len(re.findall(before + re.escape(fact) + after, text))
