"""Every model has a reference page of its interface, which equals that of its FMU."""

from pathlib import Path

import pytest
from markdown_it import MarkdownIt

from amb_cosim.export import models
from fmi_export.building.interface_page import PageTable, interface_page, outside_code, tables
from tests.support.two_axis_controller import two_axes

REFERENCE = Path(__file__).parents[2] / "docs" / "reference"


SOURCES = {name: getattr(models, name) for name in models.MODELS} | {"linear_controller": two_axes}


@pytest.mark.parametrize("name", SOURCES)
def test_the_reference_page_matches_the_interface(name):
    source = SOURCES[name]
    model, _ = source()
    page = REFERENCE / f"interface_{name}.md"
    place = f"{source.__module__}:{source.__name__}"
    command = f"python -m fmi_export.building.interface_page {place} docs/reference/{page.name}"
    assert page.read_text(encoding="utf-8") == interface_page(model), f"regenerate with: {command}"


def test_tables_show_types_units_ranges_and_start_values(lag):
    shown = {table.title: table for table in tables(lag)}
    assert list(shown)[:4] == ["Parameters", "Inputs", "Outputs", "Faults"]
    rows = [row for title in ("Parameters", "Inputs", "Outputs") for row in shown[title].rows]
    assert len(rows) == len(lag.interface.variables)
    assert ("`offset`", "Integer", "", "0", ">= -5, <= 5", "Added to the output in whole numbers") in rows
    assert ("`gain`", "tunable Real", "", "1", "", "Gain, may change at any time") in rows
    assert ("`hold`", "Boolean", "", "false", "", "Stop following") in rows
    assert ("`steps`", "Integer", "", "", "", "Steps since the start") in rows


def test_markdown_of_a_page_renders_every_cell_verbatim(lag):
    rendered = MarkdownIt("commonmark").enable("table").render(interface_page(lag))
    for table in tables(lag):
        for cell in (cell for row in table.rows for cell in row):
            plain = outside_code(cell, lambda text: text.replace("<", "&lt;").replace(">", "&gt;"))
            assert f"<td>{plain.replace('`', '')}</td>" in rendered.replace("<code>", "").replace("</code>", "")


def test_markdown_syntax_in_texts_is_escaped(lag, monkeypatch):
    odd = PageTable("Odd", ("cell",), (("|x| < 2 * `a_b` * 3",),))
    monkeypatch.setattr("fmi_export.building.interface_page.tables", lambda model: [odd])
    assert r"| \|x\| &lt; 2 \* `a_b` \* 3 |" in interface_page(lag)
