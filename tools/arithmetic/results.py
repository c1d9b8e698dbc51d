"""Results under other arithmetic: `python -m tools.arithmetic.results [SETTING ...] [--keep FOLDER]`.

All scenarios are run and all statements of the thesis judged under each setting. Results that differ in the four
printed digits depend on last bits, which pages that quote them state.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from tools.arithmetic.settings import chosen_settings, environment_of

PRINTED = 5e-4  # relative; four digits
ALIKE = 1e-9  # absolute, for values that are zero but for rounding
NOT_RESULTS = {"wall_s", "real_time_factor", "warnings"}

Results = Mapping[str, Any]


def main(arguments: list[str]) -> int:
    """Compute results under the named settings, print those that differ, and return 0."""
    parser = argparse.ArgumentParser(prog="python -m tools.arithmetic.results", description=__doc__)
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="add the results to those in this folder")
    names, values = chosen_settings(parser, arguments)
    with tempfile.TemporaryDirectory() as folder:
        results = values.keep or Path(folder)
        results.mkdir(exist_ok=True)
        for name in names:
            print(f"== {name}", flush=True)
            with environment_of(name) as environment:
                command = [
                    sys.executable,
                    "-c",
                    f"from {__spec__.name} import compute; compute({str(results / name)!r})",
                ]
                subprocess.run(command, env=environment, check=True)
        by_setting = {path.name: json.loads(path.read_text(encoding="utf-8")) for path in sorted(results.iterdir())}
    for line in differences(by_setting):
        print(line)
    return 0


def compute(file: str) -> None:
    """Write the summaries of all scenarios and the judged statements to a file."""
    from amb_cosim.scenario.scenario import scenarios
    from source_check.evaluation import assess
    from source_check.statements import load_statements

    with ProcessPoolExecutor() as pool:
        results = dict(zip(scenarios(), pool.map(_summary, scenarios()), strict=True))
    with tempfile.TemporaryDirectory() as folder:
        for statement in assess(load_statements("bath_thesis"), Path(folder)).as_dict()["statements"]:
            results[statement["key"]] = {"verdict": statement["verdict"], "ours": statement["ours"]}
    Path(file).write_text(json.dumps(results), encoding="utf-8")


def _summary(scenario: str) -> dict[str, Any]:
    import amb_cosim

    return amb_cosim.run(scenario).summary.as_dict()


def differences(results: Mapping[str, Results]) -> list[str]:
    """Return a line for each result that differs in its printed digits, with its value under each setting."""
    by_setting = {setting: dict(_leaves(of_setting)) for setting, of_setting in results.items()}
    names = dict.fromkeys(name for leaves in by_setting.values() for name in leaves)
    lines = []
    for name in names:
        values = [leaves.get(name) for leaves in by_setting.values()]
        if not all(_alike(values[0], value) for value in values):
            texts = (f"{setting} {_text(value)}" for setting, value in zip(by_setting, values, strict=True))
            lines.append(f"{name}: {', '.join(texts)}")
    return lines


def _leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else None
    if items is None:
        yield name, value
        return
    for key, entry in items:
        if key not in NOT_RESULTS:
            yield from _leaves(entry, f"{name}.{key}".lstrip("."))


def _alike(one: Any, other: Any) -> bool:
    if isinstance(one, float | int) and isinstance(other, float | int):
        return math.isclose(one, other, rel_tol=PRINTED, abs_tol=ALIKE)
    return bool(one == other)


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
