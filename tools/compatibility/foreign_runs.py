"""Runs FMUs in sequence, each alone: `python -m tools.compatibility.foreign_runs RUNNER REQUESTS FOLDER`.

REQUESTS is a JSON file, a list of FMU files with their outputs, start, stop and step (s). Time and outputs of FMU k are
in FOLDER/k.npz, elements of arrays in columns. The reason for a failure is in FOLDER/k.txt, which is written before the
run, because an FMU can end the process. FMUs with either file are skipped.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Columns = dict[str, NDArray[np.float64]]
SYSTEM = """
[[component]]
name = "fmu"
fmu = {fmu}

[experiment]
communication_step = {step}
start_time = {start}
stop_time = {stop}
"""


def with_fmpy(run: dict[str, Any]) -> Columns:
    """Return time and outputs in FMPy."""
    from fmpy import simulate_fmu

    times = {"start_time": run["start"], "stop_time": run["stop"], "output_interval": run["step"]}
    options = {"output": run["outputs"], "fmi_type": "CoSimulation", "validate": False}
    record = simulate_fmu(run["fmu"], **times, **options)
    return {str(name): np.asarray(record[name], float).reshape(len(record), -1) for name in record.dtype.names or ()}


def with_this_master(run: dict[str, Any]) -> Columns:
    """Return time and outputs in this master."""
    import amb_cosim

    with tempfile.TemporaryDirectory() as folder:
        system = Path(folder) / "alone.toml"
        system.write_text(SYSTEM.format(**run | {"fmu": json.dumps(run["fmu"])}), encoding="utf-8")
        data = amb_cosim.simulate(system, isolated=False).dataset
    columns = {"time": np.asarray(data["time"].values, float)[:, None]}
    for name in run["outputs"]:
        elements = [v for v in data if v == f"fmu.{name}" or str(v).startswith(f"fmu.{name}[")]
        columns[name] = np.column_stack([np.asarray(data[v].values, float) for v in elements])
    return columns


RUNNERS = {"fmpy": with_fmpy, "this_master": with_this_master}


def main(runner: str, requests: str, folder: str) -> None:
    """Run the FMUs of a file of requests that have no result in a folder."""
    for k, run in enumerate(json.loads(Path(requests).read_text(encoding="utf-8"))):
        values, reason = (Path(folder) / f"{k}{suffix}" for suffix in (".npz", ".txt"))
        if values.exists() or reason.exists():
            continue
        reason.write_text("it ended the process or took too long", encoding="utf-8")
        try:
            columns: dict[str, Any] = RUNNERS[runner](run)
            np.savez(values, **columns)
            reason.unlink()
        except Exception as error:
            reason.write_text(f"{type(error).__name__}: {error}", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
