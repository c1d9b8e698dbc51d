"""Table of the quantities in several summaries, with their differences from the first summary."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from rich.table import Table

from amb_cosim.presentation.json_data import units_of
from amb_cosim.presentation.text_tables import TextBlock, number, text_table
from amb_cosim.presentation.units import SIZES, convert_units_in_text, frequency_unit, relabelled, speed_unit
from amb_cosim.results.summary import Summary

BAND = "peak_band"  # the frequency up to which the modes are accurate
COST = ("wall", "real_time_factor", "steps_by_method")
LEFT_OUT = ("scenario", "flavour", *COST, "contact_states", "touchdown", "warnings", "notices", "verdict")
ABSOLUTE = ("1", "cycle")  # units whose differences are absolute rather than percentages
MOST_PERCENT = 1000.0  # percentage above which the absolute difference is printed
FORCES = {"averaged_contact_force": "largest contact force", "peak_contact_force": "largest force between impacts"}
ROUNDING = 1e-12  # of the first run's value; a smaller difference is printed as none

Value = float | str | bool | None


@dataclass(frozen=True)
class ComparedValue:
    """A quantity with its values in all runs.

    quantity
        Its key in the summary, with its bearing, site or state.
    unit
        Its unit; empty for texts.
    values
        Value of each run; may be None.
    differences
        Value minus the value of the first run; None if one of the two is not a number.
    """

    quantity: str
    unit: str
    values: tuple[Value, ...]
    differences: tuple[float | None, ...]


def rows_of(summaries: Sequence[Summary]) -> tuple[ComparedValue, ...]:
    """Return the quantities of all runs, in the order of the summary."""
    flat = [dict(_flat(summary)) for summary in summaries]
    units = {name: unit for values in flat for name, (_, unit) in values.items()}
    rows = []
    for name, unit in units.items():
        values = tuple(result.get(name, (None, ""))[0] for result in flat)
        rows.append(ComparedValue(name, unit, values, tuple(_difference(value, values[0]) for value in values)))
    return tuple(row for row in rows if any(value is not None for value in row.values))


def verdicts_and_facts(labels: Sequence[str], summaries: Sequence[Summary]) -> list[TextBlock]:
    """Return the verdict of each run, and a table of the quantities that `amb-cosim run` prints below a verdict."""
    verdicts = [f"{label}: {summary.verdict}" for label, summary in zip(labels, summaries, strict=True)]
    facts = [dict(summary.verdict.facts) for summary in summaries]
    table = Table(box=None, padding=(0, 2, 0, 0))
    for heading in ("", *labels):
        table.add_column(heading)
    for name in dict.fromkeys(name for of_run in facts for name in of_run):
        table.add_row(name, *(convert_units_in_text(of_run.get(name, "-")) for of_run in facts))
    return [*verdicts, table]


def table_of(rows: Sequence[ComparedValue], labels: Sequence[str]) -> Table:
    """Return a table with a column for each run and, except for the first, a column of differences from the first.

    Quantities that are zero in all runs are left out.
    """
    first, *others = labels
    headings = ["", "unit", first]
    for label in others:
        headings += [label, "difference"]
    table = text_table("", headings, left=("", "unit"))
    for row in rows:
        if not any(row.values):
            continue
        shown = _in_display_units(row)
        name, *place = row.quantity.split(" ", 1)
        cells = [" ".join([FORCES.get(name, name), *place]).replace("_", " "), shown.unit, _cell(shown.values[0])]
        for run in range(1, len(labels)):
            cells += [_cell(shown.values[run]), _change(shown, run)]
        table.add_row(*cells)
    return table


def _in_display_units(row: ComparedValue) -> ComparedValue:
    """Return a quantity in the chosen unit; without a choice, speeds and frequency bands get their usual units."""
    if row.unit == "rad/s":
        unit = frequency_unit() if row.quantity == BAND else speed_unit()
        label, factor = unit.label, 1.0 / unit.size
    else:
        label, factor = relabelled(row.unit, *SIZES)
    values = tuple(value * factor if isinstance(value, float) else value for value in row.values)
    differences = tuple(None if difference is None else difference * factor for difference in row.differences)
    return replace(row, unit=label, values=values, differences=differences)


def _flat(summary: Summary) -> Iterator[tuple[str, tuple[Value, str]]]:
    """Yield the name, value and unit of each quantity, with a separate name for each bearing, site or state."""
    units = units_of(Summary)
    for quantity in (field.name for field in fields(summary) if field.name not in LEFT_OUT):
        states = dict(enumerate(summary.contact_states)) if quantity == "contact_share" else {}
        label = "relative_energy_balance" if quantity == "energy_balance" else quantity
        values = _whirl_speeds(summary) if quantity == "whirl_speed" else getattr(summary, quantity)
        for name, value in _leaves(label, values, states):
            yield name, (value, units.get(quantity, "").replace(".", " "))


def _whirl_speeds(summary: Summary) -> dict[str, float | None]:
    """Return the mean whirl speed at each site (rad/s); it is None at sites where a fallen rotor did not whirl."""
    fallen = {} if summary.touchdown is None else summary.touchdown.retainers
    still = {site for site, item in fallen.items() if item.whirl == "none"}
    return {site: None if site in still else speed for site, speed in summary.whirl_speed.items()}


def _leaves(name: str, value: Any, states: Mapping[int, str]) -> Iterator[tuple[str, Value]]:
    if isinstance(value, Mapping):
        for k, (key, entry) in enumerate(value.items()):
            yield from _leaves(f"{name} {states.get(k, key)}", entry, {})
    else:
        yield name, value


def _difference(value: Value, first: Value) -> float | None:
    if isinstance(value, bool | str | None) or isinstance(first, bool | str | None):
        return None
    return value - first


def _cell(value: Value) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else number(value)


def _change(row: ComparedValue, run: int) -> str:
    """Return a run's difference from the first run, in percent; for shares and cycles, the difference is absolute."""
    difference, first = row.differences[run], row.values[0]
    if difference is None or isinstance(first, bool | str | None):
        return ""
    if abs(difference) <= ROUNDING * abs(first):
        return "0"
    if first == 0.0 or row.unit in ABSOLUTE or abs(100.0 * difference / first) > MOST_PERCENT:
        return f"{difference:+.3g}"
    return f"{100.0 * difference / abs(first):+.3g} %"
