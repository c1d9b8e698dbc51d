"""Branch coverage of kernels, slaves and master: `python -m tests.coverage [python] [c]`, both by default.

`python` runs the tests of the models without numba, so that coverage.py sees the kernels, and those of export and
master as usual; `c` those of the libraries in C, compiled by gcc. The exit code is the number of parts below 95 %.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from tests.coverage.gcc import of_branches

ROOT = Path(__file__).resolve().parents[2]
LEAST = 95.0  # per cent of the branches

WITHOUT_NUMBA = [
    *("tests/rotor_contact", "tests/amb_actuator", "tests/rolac_controller"),
    *("--ignore-glob=*test_fmu.py", "--ignore-glob=*test_readme.py"),
    *("-p", "tests.coverage.limit", "--test-seconds", "5"),
]
WITH_NUMBA = [f"tests/{name}" for name in ("fmi_export", "levitated_rotor", "orchestrator", "cosim", "ssp")]
C = [
    *("tests/native", "tests/fmi_export", "tests/orchestrator/test_compiled.py"),
    # The counters are exported too.
    "--deselect=tests/native/test_exports.py::test_the_linux_library_exports_the_fmi_functions_alone",
    "--deselect=tests/fmi_export/test_guard.py::test_the_guard_has_the_functions_of_the_standard_and_no_python",
]


def main(parts: list[str]) -> int:
    """Measure the parts and print a table of each; return how many are below the limit."""
    measures: dict[str, Callable[[Path], bool]] = {"python": _python, "c": _c}
    unknown = set(parts) - set(measures)
    if unknown:
        sys.exit(f"there is no part {', '.join(sorted(unknown))}; there are {', '.join(measures)}")
    with tempfile.TemporaryDirectory() as folder:
        return [measure(Path(folder)) for name, measure in measures.items() if name in (parts or measures)].count(False)


def _python(folder: Path) -> bool:
    environment = os.environ | {"CI": "1", "COVERAGE_FILE": str(folder / "data")}

    def coverage(*arguments: str, **settings: str) -> None:
        command = [sys.executable, "-m", "coverage", *arguments]
        subprocess.run(command, cwd=ROOT, env=environment | settings, check=False)

    coverage("run", "-m", "pytest", "-q", "-n", "0", *WITHOUT_NUMBA, NUMBA_DISABLE_JIT="1")
    # In a new cache kernels are compiled, which runs what compiles them.
    coverage("run", "-m", "pytest", "-q", "-n", "0", *WITH_NUMBA, NUMBA_CACHE_DIR=str(folder / "numba"))
    coverage("combine", "--quiet")
    coverage("report")
    coverage("json", "--quiet", f"-o{folder / 'report.json'}")
    totals = json.loads((folder / "report.json").read_text(encoding="utf-8"))["totals"]
    return _tell("Python", totals["num_branches"], totals["missing_branches"])


def _c(folder: Path) -> bool:
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "tests.coverage.gcc", "--counters", folder, *C]
    subprocess.run(command, cwd=ROOT, check=False)
    total = missing = 0
    for file, branches in sorted(of_branches(folder).items()):
        missed = [line for (line, _), count in branches.items() if not count]
        total, missing = total + len(branches), missing + len(missed)
        if missed:
            _tell(file, len(branches), len(missed))
            print(f"    lines {', '.join(str(line) for line in sorted(set(missed)))}")
    return _tell("C", total, missing)


def _tell(name: str, total: int, missing: int) -> bool:
    """Print a row of a table; return whether it is enough."""
    share = 100.0 * (total - missing) / max(total, 1)
    print(f"{name:24}{total:8} branches{missing:6} not taken{share:8.1f} %", flush=True)
    return share >= LEAST


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
