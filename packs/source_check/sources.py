"""Runs and studies for statements, each of which is computed once, in a separate process, and stored."""

from __future__ import annotations

import base64
import hashlib
import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amb_analysis.studies.processes import simulate_in_processes
from amb_assessment.reporting.panels import Panel, panel_of
from amb_assessment.reporting.pictures import picture_of
from amb_cosim.cosim.run.options import Progress
from amb_cosim.scenario.file import read_scenario
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import execute
from amb_files.atomic import write_file
from amb_files.packs import files_of, packs
from amb_files.toml import parse_toml, read_text
from amb_sweeps.stored_robustness import FILE as ROBUSTNESS
from fmi_export.building.identity import package_folder
from source_check.quantities import (
    panels_of_run,
    panels_of_study,
    quantities_of_runs,
    quantities_of_studies,
)
from source_check.requests import QuantityRequest, evaluate
from source_check.source_runs import build_fmus, prepare_source
from source_check.statements import FILE, Source
from source_check.study_quantities import compute
from source_check.verdict import Computed

PACKAGES = (
    *("amb_cosim", "rotor_contact", "amb_actuator", "rolac_controller", "levitated_rotor"),
    *("rotor_analysis", "fmi_export", "amb_files", "source_check"),
)
CODE = (".py", ".c", ".h", ".ll", ".toml")
OTHER = (
    "scenarios/",
    "sweeps/",
    FILE,
    ROBUSTNESS,
    *(f"{name}.py" for name in ("page", "table", "texts", "report_command", "robustness_runs")),
    "reporting/page_parts.py",
    "commands",
)
FOLDER = "sources"  # in the folder of the report


@dataclass(frozen=True)
class Job:
    """A source with its requests, and the file that stores the answer.

    `quantities` is the name of a module outside this package that contains further quantities.
    """

    name: str
    source: Source
    quantities: str
    requests: tuple[QuantityRequest, ...]
    file: Path
    key: str


@dataclass(frozen=True)
class SourceResult:
    """Results of a source.

    key
        Key of the job.
    values, failures
        Requested values in their units, and reasons for missing values, both by key of the request.
    title, text, parameters
        Title of the run or the study, text of the scenario file, and settings.
    panels, picture
        Plots as data, and a picture of them (PNG).
    wall
        Wall-clock time (s).
    """

    key: str
    values: Mapping[str, Computed]
    failures: Mapping[str, str]
    title: str
    text: str
    parameters: tuple[tuple[str, str], ...]
    panels: tuple[Panel, ...]
    picture: bytes
    wall: float


def code_digest() -> str:
    """Return a hash of the code, rotors and systems on which answers depend, excluding the text of scenarios."""
    sha = hashlib.sha256()
    for folder in (*map(package_folder, PACKAGES), *packs().values()):
        for file in sorted(folder.rglob("*")):
            name = file.relative_to(folder).as_posix()
            if file.suffix in CODE and not name.startswith(OTHER):
                sha.update(f"{folder.name}/{name}\0".encode() + file.read_bytes() + b"\0")
    return sha.hexdigest()


def job_of(
    name: str, source: Source, quantities: str, requests: Sequence[QuantityRequest], folder: Path, code: str
) -> Job:
    """Return the job of a source; the key of the job changes with the scenario, parameters, requests and code."""
    ordered = tuple(sorted(set(requests), key=lambda request: request.key))
    scenario = read_scenario(source.scenario) if source.scenario else None
    facts = [name, source.model_dump(mode="json"), scenario, [request.key for request in ordered], code]
    key = hashlib.sha256(json.dumps(facts, sort_keys=True, default=str).encode()).hexdigest()
    return Job(name, source, quantities, ordered, folder / FOLDER / f"{name}.json", key)


def answers(jobs: Sequence[Job], processes: int | None, progress: Progress) -> dict[str, SourceResult]:
    """Return the answer of each job, by the name of its source.

    An answer that is stored under the job's key is read. All other answers are computed in parallel processes and
    stored.

    Parameters
    ----------
    jobs
        Jobs to answer.
    processes
        Largest number of processes; by default one per processor.
    progress
        Function that is called with the number of finished jobs and the number of all jobs.

    Raises
    ------
    OSError
        If an answer cannot be written.
    """
    result = {job.name: answer for job in jobs if (answer := _stored(job)) is not None}
    open_jobs = [job for job in jobs if job.name not in result]
    progress(len(result), len(jobs))
    if open_jobs:
        open_jobs[0].file.parent.mkdir(parents=True, exist_ok=True)
        build_fmus(job.source for job in open_jobs)
        simulate_in_processes(
            keep_answer, open_jobs, lambda done, _: progress(len(result) + done, len(jobs)), processes=processes
        )
    return {job.name: result.get(job.name) or _read(job) for job in jobs}


def keep_answer(job: Job) -> None:
    """Run the source of a job, evaluate the requests, and store the answer; a failure is part of the answer."""
    begin = time.perf_counter()
    try:
        facts = _run_facts(job) if job.source.scenario else _study_facts(job)
    except (ValueError, LookupError, ArithmeticError, RuntimeError) as error:
        reason = f"{type(error).__name__}: {error}" if not str(error) else str(error)
        facts = {"values": {}, "failures": {item.key: reason for item in job.requests}, "title": job.name, "text": ""}
        facts |= {"parameters": [], "panels": [], "picture": ""}
    text = json.dumps({"key": job.key, **facts, "wall": time.perf_counter() - begin}, allow_nan=False)
    write_file(job.file, text)


def _run_facts(job: Job) -> dict[str, Any]:
    source = job.source
    prepared = prepare_source(source)
    result = execute(prepared)
    if result.outcome.failure is not None:
        raise ValueError(f"the run ended early: {result.outcome.failure}")
    changes = dict(source.set) | source.model_dump(include={"end_cycle", "unbalance_factor"}, exclude_none=True)
    changes |= {"system": source.system} if source.system else {}
    changes |= {"rotor": source.rotor_file} if source.rotor_file else {}
    changes |= {f"rotor {table}.{key}": v for table, values in source.rotor.items() for key, v in values.items()}
    return {
        "title": source.title or prepared.scenario.description,
        "text": scenario_text(source.scenario),
        "parameters": _texts(scenario_parameters(source.scenario) | changes),
        **_evaluate_all(job, result.signals, quantities_of_runs(job.quantities)),
        **_plots(panels_of_run(result.signals, job.quantities)),
    }


def _study_facts(job: Job) -> dict[str, Any]:
    source = job.source
    result = compute(source.study, dict(source.arguments))
    return {
        "title": source.title or study_title(source.study),
        "text": "",
        "parameters": [("study", source.study), *_texts(source.arguments)],
        **_evaluate_all(job, result, quantities_of_studies(job.quantities)),
        **_plots(panels_of_study(result, job.quantities)),
    }


def _texts(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [(name, str(value)) for name, value in values.items()]


def _plots(panels: Sequence[Panel]) -> dict[str, Any]:
    picture = base64.b64encode(picture_of(panels)).decode("ascii")
    return {"panels": [panel.as_data() for panel in panels], "picture": picture}


def _evaluate_all(job: Job, subject: Any, quantities: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    values, failures = {}, {}
    for item in job.requests:
        try:
            values[item.key] = evaluate(subject, item, quantities)
        except (ValueError, LookupError, TypeError, AttributeError, AssertionError) as error:
            failures[item.key] = f"{item.quantity}: {error or type(error).__name__}"
    missing = {key: "the run has no such value" for key, value in values.items() if value is None}
    return {"values": {k: v for k, v in values.items() if v is not None}, "failures": failures | missing}


def scenario_text(name: str) -> str:
    """Return the text of a scenario file, preceded by the texts of the files on which it is based."""
    text = read_text(files_of("scenarios")[name], name)
    base = parse_toml(text, name).get("base")
    headed = f"# {name}.toml\n{text}"
    return headed if base is None else f"{scenario_text(str(base))}\n{headed}"


def scenario_parameters(name: str) -> dict[str, Any]:
    """Return the settings of a scenario under the names in its file: speed, factor, inputs, parameters and events."""
    scenario = load_scenario(name)
    result: dict[str, Any] = {"scenario": name, "Omega": scenario.Omega}
    if scenario.unbalance_factor != 1.0:
        result["unbalance_factor"] = scenario.unbalance_factor
    for table in (scenario.inputs, scenario.parameters):
        result |= {
            f"{component}.{variable}": raw for component, values in table.items() for variable, raw in values.items()
        }
    for event in scenario.event:
        when = f"cycle {event.cycle:g}" if event.cycle is not None else str(event.time)
        result |= {
            f"{component}.{variable}, {when}": raw
            for component, values in event.set.items()
            for variable, raw in values.items()
        }
    return result


def study_title(study: str) -> str:
    """Return a one-line description of a study."""
    from amb_analysis.studies import STUDIES

    return STUDIES[study].description if study in STUDIES else "Start values of the models"


def _stored(job: Job) -> SourceResult | None:
    try:
        answer = _read(job)
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return answer if answer.key == job.key else None


def _read(job: Job) -> SourceResult:
    data = json.loads(job.file.read_text(encoding="utf-8"))
    parameters, panels = tuple((k, v) for k, v in data["parameters"]), tuple(map(panel_of, data["panels"]))
    return SourceResult(
        **data | {"parameters": parameters, "panels": panels, "picture": base64.b64decode(data["picture"])}
    )
