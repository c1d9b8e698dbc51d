"""The process that `verification` starts: it runs the experiments of an extracted FMU in FMPy, and compares."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import read_model_description, simulate_fmu
from numpy.typing import NDArray

from amb_cosim.cosim.descendants import adopt_orphans, end_descendants
from amb_cosim.cosim.isolated import end_with_parent, limit_memory
from amb_cosim.cosim.isolation import ERROR, RECORDING
from amb_cosim.cosim.reference_experiments import ReferenceExperiment, Table, read_experiments
from amb_cosim.cosim.verification import TOLERANCE, Deviation, Verified

Numbers = NDArray[np.float64]
NO_NUMBERS = ("String", "Binary", "Clock")


def main() -> None:
    """Answer with what was verified, or with the error."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)  # what FMUs print does not go among the answers
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        (folder,) = pickle.load(sys.stdin.buffer)
        adopt_orphans()
        threading.Thread(target=end_with_parent, daemon=True).start()
        limit_memory()
        try:
            answer: tuple[Any, ...] = (RECORDING, [_verified(folder, one) for one in read_experiments(folder)])
        except Exception as error:
            answer = (ERROR, error if isinstance(error, ValueError) else ValueError(str(error)))
        pickle.dump(answer, answers)
        answers.flush()
    end_descendants(os.getpid())
    os._exit(0)


def _verified(folder: Path, one: ReferenceExperiment) -> Verified:
    """Run an experiment and compare its results with the references."""
    tolerance = max(TOLERANCE, one.tolerance or 0.0)
    if one.unread:
        return Verified(one.name, tolerance, unread=one.unread)
    description = read_model_description(str(folder), validate=False)
    variables = {v.name: v for v in description.modelVariables}
    names = [name for name in one.references if name != "time"]
    unknown = sorted({*names, *one.stimuli, *one.parameters} - {*variables, "time"})
    if unknown:
        raise ValueError(f"{one.name}: the FMU has no variables {', '.join(unknown)}")
    names = [name for name in names if variables[name].type not in NO_NUMBERS]
    said: list[str] = []

    def log(_: Any, __: Any, status: int, ___: Any, text: bytes) -> None:
        if status > 1:
            said.append(text.decode("utf-8", "replace"))

    start, varying = _inputs(one.stimuli)
    parameters = {name: _value(variables[name], text) for name, text in one.parameters.items()}
    try:
        found = simulate_fmu(
            str(folder),
            validate=False,
            start_time=one.start_time,
            stop_time=one.stop_time,
            output_interval=one.step_size or _spacing(one.references["time"]),
            relative_tolerance=one.tolerance,
            start_values=parameters | start,
            input=varying,
            output=names,
            logger=log,
        )
    except Exception as error:
        return Verified(one.name, tolerance, failure=said[-1] if said else str(error))
    compared = {name: one.references[name] for name in ("time", *names)}
    return _compared(one, tolerance, compared, {name: np.asarray(found[name]) for name in compared})


def _spacing(texts: list[str]) -> float | None:
    """Return the time between two rows (s), None where it changes or there is but one."""
    steps = np.diff([_number(text) for text in texts])
    return float(np.mean(steps)) if len(steps) and np.allclose(steps, steps[0], rtol=1e-6) else None


def _inputs(stimuli: Table) -> tuple[dict[str, str], NDArray[Any] | None]:
    """Return inputs that stay as they are, as start values (arrays too), and the others over time."""
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
    """Return the value of a parameter as FMPy takes it: an Enumeration's as a number."""
    items = variable.declaredType.items if variable.type == "Enumeration" and variable.declaredType else None
    return next((str(item.value) for item in items or () if item.name == text), text)


def _number(text: str) -> float:
    return float({"true": "1", "false": "0"}.get(text.strip().lower(), text))


def _compared(
    one: ReferenceExperiment, tolerance: float, references: Table, found: Mapping[str, NDArray[Any]]
) -> Verified:
    """Compare results with references, those between two points of the results by a straight line between these."""
    times = np.array([float(text) for text in references["time"]])
    points = found["time"]
    nearest = np.abs(points[:, None] - times[None, :]).argmin(axis=0)
    on_points = np.allclose(points[nearest], times, rtol=1e-9, atol=1e-12)
    largest: Deviation | None = None
    n_values = 0
    for name, column in references.items():
        if name == "time":
            continue
        expected = np.array([[_number(item) for item in text.split()] for text in column])
        values = found[name].astype(float).reshape(len(points), -1)
        values = values[nearest] if on_points else _between(times, points, values)
        n_values += expected.size
        gaps = np.where(expected == values, 0.0, np.abs(values - expected))
        scale = np.abs(expected).max() or 1.0
        relative = np.where(np.isfinite(gaps), gaps / scale, np.inf)
        row, item = np.unravel_index(int(relative.argmax()), relative.shape)
        if relative[row, item] > (largest.relative if largest else 0.0):
            element = f"{name}[{item}]" if expected.shape[1] > 1 else name
            pair = float(expected[row, item]), float(values[row, item])
            largest = Deviation(element, float(times[row]), *pair, float(relative[row, item]))
    return Verified(one.name, tolerance, len(times), n_values, largest)


def _between(times: Numbers, points: Numbers, values: Numbers) -> Numbers:
    return np.column_stack([np.interp(times, points, column) for column in values.T])


if __name__ == "__main__":
    main()
