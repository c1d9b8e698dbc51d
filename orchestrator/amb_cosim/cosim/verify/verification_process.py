"""The process that `verification` starts: it runs an extracted FMU's experiments in FMPy and compares the results."""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import instantiate_fmu, read_model_description, simulate_fmu
from numpy.typing import NDArray

from amb_cosim.cosim.fmu.fmu_description import inherited
from amb_cosim.cosim.processes.child_process import limit_memory
from amb_cosim.cosim.processes.descendants import end_descendants, end_with_parent
from amb_cosim.cosim.record.differences import differences
from amb_cosim.cosim.run.isolation import ERROR, RECORDING
from amb_cosim.cosim.verify.reference_experiments import ReferenceExperiment, Table, read_experiments
from amb_cosim.cosim.verify.verification import MOST_TOLERANCE, TOLERANCE, Deviation, Verified
from amb_cosim.cosim.verify.watched_instance import WatchedInstance
from array_types import Array, Indices

NO_NUMBERS = ("String", "Binary", "Clock")


def main() -> None:
    """Send the results, or the error."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)  # keeps what FMUs print out of the answers
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        (folder,) = pickle.load(sys.stdin.buffer)
        end_with_parent(sys.stdin.buffer.read)
        limit_memory()
        try:
            answer: tuple[Any, ...] = (RECORDING, [_verified(folder, each) for each in read_experiments(folder)])
        except Exception as error:
            answer = (ERROR, error if isinstance(error, ValueError) else ValueError(str(error)))
        pickle.dump(answer, answers)
        answers.flush()
    end_descendants(os.getpid())
    os._exit(0)


def _verified(folder: Path, experiment: ReferenceExperiment) -> Verified:
    """Run an experiment and compare its results with the references."""
    allowed = experiment.tolerance or 0.0
    tolerance = min(max(TOLERANCE, allowed), MOST_TOLERANCE)
    if experiment.unread:
        return Verified(experiment.name, tolerance, unread=experiment.unread)
    description = read_model_description(str(folder), validate=False)
    default = description.defaultExperiment
    start_time, stop_time = (
        float(stated if stated is not None else getattr(default, name, None) or fallback)
        for stated, name, fallback in (
            (experiment.start_time, "startTime", 0.0),
            (experiment.stop_time, "stopTime", 1.0),
        )
    )
    if fault := _fault_of_times(experiment.references["time"], start_time, stop_time):
        return Verified(experiment.name, tolerance, unread=fault)
    variables = {v.name: v for v in description.modelVariables}
    names = [name for name in experiment.references if name != "time"]
    unknown = sorted({*names, *experiment.stimuli, *experiment.parameters} - {*variables, "time"})
    if unknown:
        raise ValueError(f"{experiment.name}: the FMU has no variables {', '.join(unknown)}")
    reasons = {name: _reason_to_omit(variables[name], experiment) for name in names}
    omitted = tuple(f"{name} ({reason})" for name, reason in reasons.items() if reason)
    texts = {name: variables[name] for name in names if not reasons[name] and variables[name].type == "String"}
    names = [name for name in names if not reasons[name] and name not in texts]
    references = {name: _numbers(name, experiment.references[name]) for name in names}
    if not names and not texts:
        listing = f"; it has {', '.join(omitted)}" if omitted else ""
        unread = f"its reference results contain no numbers to compare{listing}"
        return Verified(experiment.name, tolerance, unread=unread)
    infinite = next((name for name in names if not np.isfinite(references[name]).all()), None)
    if infinite is not None:
        return Verified(experiment.name, tolerance, unread=f"its reference results of {infinite} are not all finite")
    errors: list[str] = []
    try:
        result, seen = _simulated(folder, description, experiment, (start_time, stop_time), (names, texts), errors)
    except Exception as error:
        return Verified(experiment.name, tolerance, failure=errors[-1] if errors else str(error))
    times = np.array([_number(text) for text in experiment.references["time"]])
    end = float(result["time"][-1])
    if end < times[-1] - 1e-6 * (stop_time - start_time):
        failure = f"it ended the simulation at {end:.9g} s, but its reference results end at {times[-1]:.9g} s"
        return Verified(experiment.name, tolerance, failure=failure)
    n_texts, other = _compared_texts(experiment.references, times, [*texts], seen)
    values = {name: np.asarray(result[name]) for name in ("time", *names)}
    units = {name: inherited(variables[name], "unit") for name in names}
    largest = _largest_deviation(times, references, values, units)
    n_values = sum(column.size for column in references.values()) + n_texts
    return Verified(
        experiment.name, tolerance, len(times), n_values, largest, allowed=allowed, omitted=omitted, other_text=other
    )


def _simulated(
    folder: Path,
    description: Any,
    experiment: ReferenceExperiment,
    times: tuple[float, float],
    compared: tuple[list[str], Mapping[str, Any]],
    errors: list[str],
) -> tuple[Any, list[tuple[float, list[str]]]]:
    """Run an experiment in FMPy.

    Parameters
    ----------
    folder, description, experiment
        The extracted FMU, its modelDescription, and the experiment.
    times
        Start and stop time (s).
    compared
        Names of the numbers to record, and the Strings by name.
    errors
        Receives the errors that the FMU logs.

    Returns
    -------
    tuple
        The result of FMPy, and the Strings at each time (s).
    """

    def log(*arguments: Any) -> None:  # the instance as well in FMI 2.0; then status, category and text
        *_, status, _, text = arguments
        if status > 1:
            errors.append((text or b"").decode("utf-8", "replace"))

    variables = {v.name: v for v in description.modelVariables}
    start, varying = _inputs(experiment.stimuli)
    parameters = {name: _value(variables[name], text) for name, text in experiment.parameters.items()}
    fmu = instantiate_fmu(str(folder), description, "CoSimulation", logger=log, require_functions=False)
    names, texts = compared
    watched = WatchedInstance(fmu, [variable.valueReference for variable in texts.values()], times[0])
    result = simulate_fmu(
        str(folder),
        validate=False,
        start_time=times[0],
        stop_time=times[1],
        output_interval=experiment.step_size or _spacing(experiment.references["time"]),
        relative_tolerance=min(experiment.tolerance or 0.0, MOST_TOLERANCE) or None,
        start_values=parameters | start,
        input=varying,
        output=names,
        fmi_type="CoSimulation",
        model_description=description,
        fmu_instance=watched,
        early_return_allowed=True,  # `WatchedInstance` refuses it with a reason
    )
    fmu.freeInstance()
    return result, watched.seen


def _compared_texts(
    references: Table, times: Array, names: list[str], seen: list[tuple[float, list[str]]]
) -> tuple[int, str]:
    """Compare the values of Strings with the references, at the times of the references.

    Returns
    -------
    tuple
        The number of compared texts, and a phrase on the first text that differs, or an empty text.
    """
    count, first = 0, ""
    points = np.array([time for time, _ in seen])
    for row, time in enumerate(times):
        for k in np.flatnonzero(np.isclose(points, time, rtol=1e-9, atol=1e-12))[-1:]:
            for name, computed in zip(names, seen[k][1], strict=True):
                expected, count = references[name][row], count + 1
                if computed != expected and not first:
                    first = f"{name} = {computed!r}, reference {expected!r}, at t = {time:.9g} s"
    return count, first


def _reason_to_omit(variable: Any, experiment: ReferenceExperiment) -> str:
    """Return why a column of the references proves nothing about an FMU; an empty text if it proves something."""
    if variable.type in NO_NUMBERS and not (variable.type == "String" and not variable.shape):
        return f"of type {variable.type}{', an array' if variable.shape else ''}"
    if variable.causality == "input":
        return "an input"
    if variable.causality == "independent":
        return "the time"
    return "a parameter that the experiment sets" if variable.name in experiment.parameters else ""


def _fault_of_times(texts: list[str], start_time: float, stop_time: float) -> str:
    """Return a phrase on what is wrong with the times of reference results (s); empty if they ascend within the run."""
    if not stop_time > start_time:
        return f"its stop time of {stop_time:g} s is not after its start at {start_time:g} s"
    times, margin = np.array([_number(text) for text in texts]), 1e-9 * (stop_time - start_time)
    if not np.isfinite(times).all() or (np.diff(times) < 0.0).any():
        return "the times of its reference results are not in ascending order"
    if times[0] < start_time - margin or times[-1] > stop_time + margin:
        run = f"the run from {start_time:g} s to {stop_time:g} s"
        return f"the times of its reference results, {times[0]:g} s to {times[-1]:g} s, are not within {run}"
    if times[-1] <= start_time + margin:
        return f"its reference results have no time after the start at {start_time:g} s"
    return ""


def _spacing(texts: list[str]) -> float | None:
    """Return the time between rows (s), or None if the rows are not equally spaced or there is only one row."""
    steps = np.diff([_number(text) for text in texts])
    return float(np.mean(steps)) if len(steps) and np.allclose(steps, steps[0], rtol=1e-6) else None


def _inputs(stimuli: Table) -> tuple[dict[str, str], NDArray[Any] | None]:
    """Return constant inputs, including arrays, as start values, and all other inputs over time."""
    columns = {name: column for name, column in stimuli.items() if name != "time"}
    constant = {name: column[0] for name, column in columns.items() if len(set(column)) == 1}
    varying = [name for name in columns if name not in constant]
    if not varying:
        return constant, None
    signals = np.zeros(len(stimuli["time"]), [(name, np.float64) for name in ("time", *varying)])
    for name in ("time", *varying):
        signals[name] = [_number(text) for text in stimuli[name]]
    return constant, signals


def _value(variable: Any, text: str) -> str:
    """Return the value of a parameter for FMPy, which requires a number for an Enumeration."""
    items = variable.declaredType.items if variable.type == "Enumeration" and variable.declaredType else None
    return next((str(item.value) for item in items or () if item.name == text), text)


def _number(text: str) -> float:
    return float({"true": "1", "false": "0"}.get(text.strip().lower(), text))


def _numbers(name: str, column: list[str]) -> Array:
    """Return the values of a variable, shape (rows, elements).

    Raises
    ------
    ValueError
        If a value is not a number, or rows differ in their number of elements.
    """
    try:
        return np.array([[_number(item) for item in text.split()] for text in column], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"the reference results of {name} must be numbers, equally many in each row") from error


def _largest_deviation(
    times: Array, references: Mapping[str, Array], results: Mapping[str, NDArray[Any]], units: Mapping[str, str | None]
) -> Deviation | None:
    """Compare results with references; results are interpolated linearly between points."""
    points = results["time"]
    nearest = _rows_at(times, points)
    on_points = np.allclose(points[nearest], times, rtol=1e-9, atol=1e-12)
    largest: Deviation | None = None
    for name, expected in references.items():
        values = results[name].astype(float).reshape(len(points), -1)
        values = values[nearest] if on_points else _between(times, points, values)
        if values.shape != expected.shape:
            sizes = f"{expected.shape[1]} values in a row, but the variable has {values.shape[1]}"
            raise ValueError(f"the reference results of {name} have {sizes}")
        gaps = np.where(expected == values, 0.0, differences(values, expected, units[name]))
        scale = np.abs(expected).max() or 1.0
        relative = np.where(np.isfinite(gaps), gaps / scale, np.inf)
        row, column = np.unravel_index(int(relative.argmax()), relative.shape)
        if relative[row, column] > (largest.relative if largest else 0.0):
            element = f"{name}[{column}]" if expected.shape[1] > 1 else name
            pair = float(expected[row, column]), float(values[row, column])
            largest = Deviation(element, float(times[row]), *pair, float(relative[row, column]))
    return largest


def _rows_at(times: Array, points: Array) -> Indices:
    """Return the row of the results that is nearest to each time of the references.

    Two references with the same time, before and after an event, correspond to the two rows of the results at this
    time. A reference at the end of the run corresponds to the last row of the results.
    """
    rows = np.abs(points[:, None] - times[None, :]).argmin(axis=0)
    for k in np.flatnonzero(np.diff(times) == 0.0) + 1:
        after = rows[k - 1] + 1
        rows[k] = after if after < len(points) and points[after] == points[rows[k]] else rows[k]
    if len(points) and np.isclose(points[rows[-1]], points[-1], rtol=1e-9, atol=1e-12):
        rows[-1] = len(points) - 1
    return rows


def _between(times: Array, points: Array, values: Array) -> Array:
    return np.column_stack([np.interp(times, points, column) for column in values.T])


if __name__ == "__main__":
    main()
