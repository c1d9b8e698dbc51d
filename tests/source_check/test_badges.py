"""Badges of the pages of verdicts: a sign beside the word, and letters that stand out in both themes."""

from __future__ import annotations

import re
from importlib import resources

import pytest

from amb_assessment.assessment.findings import Judgement as OfMachine
from source_check.verdict import Verdict as OfReport

REPORT, MACHINE = (
    resources.files(package).joinpath("template", name).read_text(encoding="utf-8")
    for package, name in (("amb_assessment.reporting", "report.css"), ("amb_assessment.assessment", "assessment.css"))
)
LIGHT, DARK = (
    dict(re.findall(r"--([\w-]+): (#\w{6})", block)) for block in re.findall(r":root \{(.*?)\}", REPORT, re.S)
)
READABLE = 4.5  # contrast of text, WCAG 2.2, 1.4.3


def luminance(colour: str) -> float:
    shares = [int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]
    red, green, blue = (s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shares)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    darker, lighter = sorted((luminance(one), luminance(other)))
    return (lighter + 0.05) / (darker + 0.05)


@pytest.mark.parametrize(("verdicts", "css"), [(OfReport, REPORT), (OfMachine, REPORT + MACHINE)])
def test_each_verdict_has_a_sign_and_can_be_read_in_both_themes(verdicts, css):
    for name in (verdict.name.lower() for verdict in verdicts):
        assert re.search(rf'\.badge\.{name}::before {{ content: "\S"; }}', css), name
        ground, letters = re.search(
            rf"\.badge\.{name} {{ background: var\(--(\S+)\); color: var\(--(\S+)\)", css
        ).groups()
        assert min(contrast(theme[ground], theme[letters]) for theme in (LIGHT, DARK)) > READABLE, name


def test_verdicts_that_differ_have_signs_that_differ():
    signs = dict(re.findall(r'\.badge\.(\w+)::before { content: "(\S)"; }', REPORT + MACHINE))
    assert len({signs[name] for name in ("reproduced", "missed", "not_computed", "with_reading", "within_limit")}) == 5
    assert len({signs[name] for name in ("met", "missed", "unanswered", "not_judged")}) == 4
