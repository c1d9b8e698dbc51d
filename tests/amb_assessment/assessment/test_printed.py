"""The page as PDF: a browser prints it, and no partial file remains if it fails."""

import sys

import pytest

from amb_assessment.assessment.page import pdf as printed

PRINTS = "target.write_text(page)"
FAILS = "target.write_text('half'); sys.exit(1)"


@pytest.fixture
def print_with(tmp_path, monkeypatch):
    """Print a page with a fake browser, a Python program that has `target` and `page`."""
    page = tmp_path / "assessment.html"
    page.write_text("<p>verdicts</p>", encoding="utf-8")
    run = printed.subprocess.run

    def printed_by(program):
        begin = "import sys, pathlib; *_, target, page = sys.argv; target = pathlib.Path(target.partition('=')[2]); "
        monkeypatch.setattr(printed, "browser", lambda: "browser")
        monkeypatch.setattr(
            printed.subprocess, "run", lambda command, **k: run([sys.executable, "-c", begin + program, *command], **k)
        )
        return printed.print_page(page)

    return printed_by


def test_a_browser_prints_the_page_beside_it(print_with, tmp_path):
    result = print_with(PRINTS)
    assert result == tmp_path / "assessment.pdf"
    assert result.read_text() == (tmp_path / "assessment.html").as_uri()


@pytest.mark.parametrize("program", [FAILS, "pass"], ids=["fails", "writes nothing"])
def test_a_browser_that_fails_leaves_no_file(print_with, tmp_path, program):
    assert print_with(program) is None
    assert [path.name for path in tmp_path.iterdir()] == ["assessment.html"]


def test_without_a_browser_there_is_no_pdf(tmp_path, monkeypatch):
    monkeypatch.setattr(printed, "browser", lambda: None)
    assert printed.print_page(tmp_path / "assessment.html") is None
    assert list(tmp_path.iterdir()) == []
