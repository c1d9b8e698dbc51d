"""Progress of the command `assess`: a bar in a terminal, a line for each part elsewhere."""

from __future__ import annotations

from click.testing import CliRunner

from amb_assessment.assessment import assess
from amb_cosim.commands.cli import main


def test_each_part_is_a_line_where_there_is_no_terminal(monkeypatch, tmp_path):
    def answer(machine, *, progress, **_):
        progress("Free modes", 0, 2)
        progress("Critical speeds", 1, 2)
        raise ValueError("ended here")

    monkeypatch.setattr(assess, "assess", answer)
    ended = CliRunner().invoke(main, ["assess", "compressor", "-o", str(tmp_path / "page")])
    assert [line.strip() for line in ended.stderr.splitlines()[:2]] == ["1 of 2: Free modes", "2 of 2: Critical speeds"]
    assert "ended here" in ended.stderr
