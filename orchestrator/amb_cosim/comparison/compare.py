"""Comparison of runs: sources, runs, differences, and output files."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from amb_cosim.comparison.signals import SignalComparison, compare_signals
from amb_cosim.comparison.table import ComparedValue, rows_of, table_of, verdicts_and_facts
from amb_cosim.cosim.choices import FLAVOURS, Flavour
from amb_cosim.cosim.errors import Interrupted, computed_by
from amb_cosim.cosim.run.options import Progress
from amb_cosim.cosim.system.values import Raw
from amb_cosim.presentation.json_data import json_data
from amb_cosim.presentation.text_tables import TextBlock, html_of, rendered
from amb_cosim.results.result import Result
from amb_cosim.scenario.rotors import RotorSource, named
from amb_cosim.scenario.scenario import Scenario, load_scenario, scenarios
from amb_cosim.scenario.simulation import run
from amb_files.atomic import plain_file, remove_files, write_file
from amb_files.checks import as_names, as_path, repeated, require_choice, require_kind
from amb_files.plain_values import plain_values

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Source = str | Path | Scenario | Result
"""A scenario (name or TOML file) or a result (folder or file)."""

MOST = 8  # runs that remain distinguishable in figures
FILE = "comparison.json"
FIGURES = ("orbits", "displacement", "contact")


@dataclass(frozen=True, eq=False)
class Side:
    """One of the compared runs.

    label
        Its unique name: the name of its scenario, followed by the settings that differ.
    source
        Name, file or folder.
    settings
        Values that replaced those in the scenario; empty for a saved result.
    result
        The run.
    """

    label: str
    source: str
    settings: Mapping[str, Raw]
    result: Result


@dataclass(frozen=True, eq=False)
class Comparison:
    """Compared runs; `print` shows their table.

    sides
        The runs; the others are compared with the first.
    rows
        Quantities of the summaries with their differences from the first run.
    signals
        The common signals, their differences, and the signals that only some runs contain.
    """

    sides: tuple[Side, ...]
    rows: tuple[ComparedValue, ...]
    signals: SignalComparison

    @property
    def labels(self) -> list[str]:
        """Names of the runs."""
        return [side.label for side in self.sides]

    @property
    def results(self) -> list[Result]:
        """The runs."""
        return [side.result for side in self.sides]

    def text(self, whole: bool = False) -> list[TextBlock]:
        """Return the verdicts, followed by a table of the facts of each run, and lines about the signals.

        With `whole`, the outcomes and the table of all quantities with their differences are also included.
        """
        short = verdicts_and_facts(self.labels, [side.result.summary for side in self.sides])
        outcomes = [f"{side.label}: {side.result.outcome}" for side in self.sides]
        others: list[TextBlock] = [table_of(self.rows, self.labels), *outcomes] if whole else []
        return [*short, *others, *self.signals.text()]

    def __str__(self) -> str:
        return rendered(self.text())

    def __repr__(self) -> str:
        return f"Comparison({', '.join(self.labels)}: {len(self.rows)} quantities)"

    def _repr_html_(self) -> str:
        return html_of(self.text())

    def as_dict(self) -> dict[str, Any]:
        """Return the data, ready for JSON."""
        runs = [
            {
                "label": side.label,
                "source": side.source,
                "settings": {name: str(value) for name, value in side.settings.items()},
                "outcome": str(side.result.outcome),
                "summary": side.result.summary.as_dict(),
            }
            for side in self.sides
        ]
        return {"runs": runs, "rows": json_data(self.rows), "signals": json_data(self.signals)}

    def to_dataframe(self) -> pd.DataFrame:
        """Return the quantities of all summaries as a table of pandas: unit and a column for each run, by quantity."""
        import pandas as pd

        data = {row.quantity: (row.unit, *row.values) for row in self.rows}
        table = pd.DataFrame.from_dict(data, orient="index", columns=["unit", *self.labels])
        return table.rename_axis("quantity")

    def figures(self) -> dict[str, Figure]:
        """Return the overlaid figures for which the runs have data: `orbits`, `displacement` and `contact`."""
        from amb_cosim.comparison.plots import overlays

        return overlays({side.label: side.result.signals for side in self.sides})

    def save(self, folder: str | Path, plots: bool = True) -> Path:
        """Write `comparison.json` and, if requested, the figures; return the folder.

        Figures of a comparison that was saved there before are removed.

        Raises
        ------
        OSError
            If the folder or a file cannot be written.
        """
        folder = as_path("folder", folder)
        text = json.dumps(self.as_dict(), indent=2, allow_nan=False) + "\n"
        folder.mkdir(parents=True, exist_ok=True)
        remove_files(folder, (f"{name}.png" for name in FIGURES))
        write_file(plain_file(folder, FILE), text)
        if plots:
            from amb_cosim.presentation.style import write_png

            for name, figure in self.figures().items():
                write_png(figure, plain_file(folder, f"{name}.png"))
        return folder


def compare(
    *sources: Source | Sequence[Source],
    set: Mapping[str, Raw] | Sequence[Mapping[str, Raw] | None] | None = None,
    rotor: RotorSource | Sequence[RotorSource] = None,
    flavour: Flavour | Sequence[Flavour] = "native",
    until: Raw | None = None,
    labels: Sequence[str] | None = None,
    progress: bool | Progress | None = None,
) -> Comparison:
    """Run scenarios or read saved results, and return their comparison.

    Each of settings, rotor and flavour is either one value for all runs or a sequence with one value per source.
    Settings for all runs do not affect saved results.

    Parameters
    ----------
    sources
        Two to eight sources, or a list of them. Each is a scenario (or its name or TOML file) or a result (or its
        folder or file).
    set
        Values by `component.variable` that replace those in the scenario.
    rotor
        A `Rotor`, the name of a packaged rotor, or a rotor file, to use instead of the scenario's rotor.
    flavour
        `native` or `python`.
    until
        End time of the runs, counted from the beginning of cycle 0, in s or as a text with a unit.
    labels
        Names of the runs in the table and the figures; by default, those of their scenarios and settings.
    progress
        As in `run`.

    Raises
    ------
    ValueError
        If there are too few or too many sources, a source is invalid, or a value is set for a saved result.
    Interrupted
        If Ctrl-C ends a run. This is a KeyboardInterrupt; its attribute `result` compares the runs until then.
    """
    chosen: list[Any] = [source for each in sources for source in (each if isinstance(each, list | tuple) else [each])]
    if not 2 <= len(chosen) <= MOST:
        raise ValueError(f"compare needs 2 to {MOST} runs, not {len(chosen)}")
    names = None if labels is None else as_names("labels", labels)
    if names is not None and (len(names) != len(chosen) or repeated(names)):
        raise ValueError(
            f"labels = {[*names]} is not allowed; it must have a different name for each of {len(chosen)} runs"
        )
    settings, rotors, flavours = (
        _for_each(value, len(chosen), name) for value, name in ((set, "set"), (rotor, "rotor"), (flavour, "flavour"))
    )
    plans = []
    for number, source in enumerate(chosen):
        loaded = load(source)
        if isinstance(loaded, Result):
            for value, values, default in ((set, settings, None), (rotor, rotors, None), (flavour, flavours, "native")):
                requested = values[number] if _is_each(value) else None
                if requested and requested != default:
                    raise ValueError(f"{_source_text(source)} is a saved result; {requested} cannot be set for it")
        require_choice("flavour", flavours[number], FLAVOURS)
        plans.append(loaded)
    if (set or rotor or until) and all(isinstance(plan, Result) for plan in plans):
        raise ValueError("settings require a scenario; all of these are saved results")
    sides: list[Side] = []
    for source, plan, its_set, its_rotor, its_flavour in zip(chosen, plans, settings, rotors, flavours, strict=True):
        if isinstance(plan, Result):
            sides.append(Side(plan.scenario, _source_text(source), {}, plan))
            continue
        result = computed_by(
            run, plan, set=its_set, rotor=its_rotor, flavour=its_flavour, until=until, progress=progress
        )
        label = _label(plan.name, its_set, its_rotor, its_flavour, (set, rotor, flavour))
        sides.append(Side(label, _source_text(source), plain_values(its_set, "set"), result))
        if result.outcome.status == "interrupted":
            raise Interrupted(f"{label} was {result.outcome}", side_by_side(_labelled(sides, names)))
    return side_by_side(_labelled(sides, names))


def _labelled(sides: Sequence[Side], labels: Sequence[str] | None) -> list[Side]:
    """Return the runs with these labels; a comparison that was interrupted has fewer runs than labels."""
    return [*sides] if labels is None else [replace(side, label=n) for side, n in zip(sides, labels, strict=False)]


def side_by_side(sides: Sequence[Side]) -> Comparison:
    """Return the comparison of runs; equal labels are numbered."""
    count = Counter(side.label for side in sides)
    named = tuple(
        Side(f"{side.label} ({k})" if count[side.label] > 1 else side.label, side.source, side.settings, side.result)
        for k, side in enumerate(sides, start=1)
    )
    labels = [side.label for side in named]
    rows = rows_of([side.result.summary for side in named])
    return Comparison(named, rows, compare_signals(labels, [side.result.signals for side in named]))


def load(source: Source) -> Scenario | Result:
    """Return the scenario or result of a source.

    Raises
    ------
    ValueError
        If there is no such scenario or result, or it is invalid.
    """
    if isinstance(source, Scenario | Result):
        return source
    require_kind("sources", source, (str, PathLike), "scenarios and results, or their names and files")
    if str(source) not in scenarios() and (Path(source).is_dir() or Path(source).suffix == ".nc"):
        return Result.load(source)
    return load_scenario(str(source))


def _source_text(source: Source) -> str:
    if isinstance(source, Result):
        return source.scenario
    return source.name if isinstance(source, Scenario) else str(source)


def _is_each(value: Any) -> bool:
    """Return whether there is one value per source."""
    return isinstance(value, Sequence) and not isinstance(value, str)


def _for_each(value: Any, count: int, name: str) -> list[Any]:
    """Return a list with the value for each source."""
    if not _is_each(value):
        return [value] * count
    if len(value) != count:
        raise ValueError(f"{name} has {len(value)} values for {count} runs; set one for all runs, or one for each run")
    return list(value)


def _label(name: str, settings: Mapping[str, Raw] | None, rotor: Any, flavour: str, requested: tuple[Any, ...]) -> str:
    """Return the name of a scenario, followed by those settings that may differ between the runs."""
    varied, rotors, flavours = (_is_each(each) for each in requested)
    parts = [f"{key}={value}" for key, value in plain_values(settings, "set").items()] if varied else []
    parts += [Path(str(named(rotor))).stem] if rotors and rotor else []
    parts += [flavour] if flavours else []
    return ", ".join([name, *parts])
