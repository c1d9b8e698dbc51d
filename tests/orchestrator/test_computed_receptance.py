"""A receptance that is computed from the linear model of the loop is not compared with that model."""

from __future__ import annotations

from rich.table import Table

from amb_analysis.studies.receptance_identification import HEADINGS
from amb_cosim import studies


def test_computed_receptance_is_compared_with_nothing() -> None:
    """Its difference from the model that it is of would be zero, whatever is wrong with the model."""
    found = studies.identify("9000 rpm", scenario="compressor_levitated", computed=True, progress=False)
    (result,), (table,) = found.results, found.text()
    assert isinstance(table, Table)
    cells = dict(zip(HEADINGS, (next(iter(column.cells)) for column in table.columns), strict=True))
    assert result.receptance is not None
    assert result.model is None
    assert (cells["differs from the model (%)"], cells[""]) == ("-", "computed, not compared")
