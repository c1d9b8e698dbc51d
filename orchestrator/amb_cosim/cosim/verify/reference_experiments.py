"""Reads the experiments in an FMU (FMI-LS-REF): runs and reference results.

The manifest names files with role `experiment`; each contains experiments in the format of the Modelica Association
(github.com/modelica/ma-hs-experiments). The times are in `Experiment` or, in recent files, in its child
`TransientSimulation`. Tables are CSV with a column `time`; an array of FMI 3.0 is one column, with values separated by
blanks. If no experiment is named, files with role `result` are the results of the FMU's default experiment, as in the
Reference-FMUs.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.etree.ElementTree import Element, ParseError, parse

from amb_files.csv_files import read_csv

MANIFEST = Path("extra", "org.fmi-standard.fmi-ls-ref", "fmi-ls-manifest.xml")

OTHER_KINDS = (  # of experiments that are not simulations over time
    *("SteadyState", "ParameterOptimization", "SetPointOptimization", "SensitivityAnalysis"),
    *("TrajectoryOptimization", "Linearization"),
)

Table = dict[str, list[str]]  # columns by their names, as texts


@dataclass(frozen=True)
class ReferenceExperiment:
    """An experiment, with values as texts, as in the files, and with times in s; None stands for the time in the FMU.

    `unread` is the reason why the experiment cannot be run.
    """

    name: str
    start_time: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    tolerance: float | None = None
    parameters: dict[str, str] = field(default_factory=dict)
    stimuli: Table = field(default_factory=dict)
    references: Table = field(default_factory=dict)
    unread: str = ""


def read_experiments(folder: Path) -> list[ReferenceExperiment]:
    """Return the experiments of an extracted FMU, if any.

    Raises
    ------
    ValueError
        If a named file is missing or invalid.
    """
    manifest = folder / MANIFEST
    if not manifest.is_file():
        return []
    related = list(_root(manifest).iter("Related"))

    def files_of(role: str) -> list[Path]:
        of_role = [entry for entry in related if entry.get("role", "").split("/")[0] == role]
        return [_beside(manifest, entry.get("source", ""), folder) for entry in of_role]

    if not (files := files_of("experiment")):
        results = [file for file in files_of("result") if file.suffix == ".csv"]
        return [ReferenceExperiment(file.stem, references=_table(file)) for file in results]
    return [_experiment(element, file, folder) for file in files for element in _root(file).iter("Experiment")]


def _experiment(element: Element, file: Path, folder: Path) -> ReferenceExperiment:
    name = element.get("name", file.stem)
    other = next((kind for kind in OTHER_KINDS if element.find(kind) is not None), "")
    times = element.find("TransientSimulation")
    times = element if times is None else times
    sources = {kind: element.find(kind) for kind in ("Parameters", "Stimuli", "References")}
    unread = f"it is not a simulation over time but {other}" if other else ""
    for kind, expected in (("Stimuli", "text/csv"), ("References", "text/csv"), ("Parameters", "parameter-set")):
        source = sources[kind]
        if source is not None and expected not in source.get("type", expected):
            unread = unread or f"its {kind.lower()} are of type {source.get('type')}, which is not supported"
    if sources["References"] is None:
        unread = unread or "it has no reference results"
    if unread:
        return ReferenceExperiment(name, unread=unread)
    start, stop, step = (_number(times, key, file) for key in ("startTime", "stopTime", "stepSize"))
    files = {kind: _beside(file, e.get("source", ""), folder) for kind, e in sources.items() if e is not None}
    return ReferenceExperiment(
        name,
        start,
        stop,
        step,
        _number(element, "tolerance", file),
        dict(_parameters(files["Parameters"])) if "Parameters" in files else {},
        _table(files["Stimuli"]) if "Stimuli" in files else {},
        _table(files["References"]),
    )


def _root(file: Path) -> Element:
    try:
        return parse(file).getroot()
    except (OSError, ParseError) as error:
        raise ValueError(f"cannot read {file.name}: {error}") from error


def _beside(file: Path, source: str, folder: Path) -> Path:
    """Return the file of a URI relative to another file; raises ValueError if it is not in the FMU."""
    uri = urlsplit(source)
    path = (file.parent / unquote(uri.path)).resolve()
    if uri.scheme or uri.netloc or not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{file.name}: source {source!r} is not a file of the FMU")
    if not path.is_file():
        raise ValueError(f"{file.name}: there is no file {source!r} in the FMU")
    return path


def _number(element: Element, key: str, file: Path) -> float | None:
    text = element.get(key)
    try:
        number = None if text is None else float(text)
    except ValueError:
        number = math.nan
    if number is not None and not math.isfinite(number):
        raise ValueError(f"{file.name}: {key} = {text!r} is not a number")
    return number


def _parameters(file: Path) -> Iterator[tuple[str, str]]:
    """Yield the parameters of an SSP parameter set of any version, by name."""
    for parameter in _root(file).iter():
        if parameter.tag.rpartition("}")[2] == "Parameter":
            for value in parameter:
                if "value" in value.attrib:
                    yield parameter.get("name", ""), value.get("value", "")


def _table(file: Path) -> Table:
    heads, rows = read_csv(file, file.name)
    if "time" not in heads:
        raise ValueError(f"{file.name} is not a table with a column 'time'")
    return {name: [row[k] for row in rows] for k, name in enumerate(heads)}
