"""Branch coverage of kernels, slaves and master: `python -m tools.coverage [kernels] [host] [c]`, all by default.

`kernels`: the compiled models, with a note at each branch. `host`: the Python code of FMUs, and the master, by
coverage.py. `c`: the C code, compiled by gcc. The exit code is the number of parts below 95 %.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path

from tools.coverage.gcc import of_branches

ROOT = Path(__file__).resolve().parents[2]
LEAST = 95.0  # per cent of the branches

MODELS = [f"tests/{name}" for name in ("rotor_contact", "amb_actuator", "rolac_controller")]
HOST = [
    *(f"tests/{name}" for name in ("fmi_export", "native", "swap", "orchestrator", "cosim", "ssp")),
    # coverage.py handles SIGTERM itself.
    "--deselect=tests/cosim/test_interruption.py::test_deferred_interrupts_leave_sigterm_at_its_default",
]
PARTS = {  # of the Python code
    "master": "orchestrator/amb_cosim/cosim",
    "what builds FMUs": "libraries/fmi_export/building",
    "models, and flavour python": "libraries/fmi_export",
}
C = [
    *("tests/native", "tests/fmi_export", "tests/cosim/test_compiled.py"),
    # The library also exports gcc's counters.
    "--deselect=tests/native/test_exports.py::test_the_linux_library_exports_only_fmi_functions",
    "--deselect=tests/fmi_export/test_guard.py::test_the_guard_has_the_functions_of_the_standard_and_no_python",
]


def main(parts: list[str]) -> int:
    """Measure the parts and print a table of each; return how many are below the limit."""
    measures: dict[str, Callable[[Path], bool]] = {"kernels": _kernels, "host": _host, "c": _c}
    unknown = set(parts) - set(measures)
    if unknown:
        sys.exit(f"there is no part {', '.join(sorted(unknown))}; there are {', '.join(measures)}")
    with tempfile.TemporaryDirectory() as folder:
        return [measure(Path(folder)) for name, measure in measures.items() if name in (parts or measures)].count(False)


def _kernels(folder: Path) -> bool:
    file = folder / "kernels.json"
    _pytest("-p", "tools.coverage.kernels", "--branches", str(file), *MODELS)
    report = json.loads(file.read_text(encoding="utf-8"))
    return _print_files("kernels", {name: [(line, taken) for line, taken in lines] for name, lines in report.items()})


def _host(folder: Path) -> bool:
    # With an empty cache kernels are compiled, which covers the code that compiles them.
    environment = os.environ | {"COVERAGE_FILE": str(folder / "data"), "NUMBA_CACHE_DIR": str(folder / "numba")}

    def coverage(*arguments: str) -> None:
        subprocess.run([sys.executable, "-m", "coverage", *arguments], cwd=ROOT, env=environment, check=False)

    coverage("run", "-m", "pytest", "-q", "-n", "0", *HOST)
    coverage("combine", "--quiet")
    coverage("json", "--quiet", f"-o{folder / 'report.json'}")
    files = json.loads((folder / "report.json").read_text(encoding="utf-8"))["files"]
    passed = []
    for name, start in PARTS.items():
        of_part = {file: files.pop(file) for file in list(files) if file.startswith(start)}
        branches_of = {
            file: [
                *((line, True) for line, _ in branches["executed_branches"]),
                *((line, False) for line, _ in branches["missing_branches"]),
            ]
            for file, branches in of_part.items()
        }
        passed.append(_print_files(name, branches_of))
    return all(passed)


def _c(folder: Path) -> bool:
    _pytest("-p", "tools.coverage.gcc", "--counters", str(folder / "counters"), *C)
    counts = of_branches(folder / "counters")
    return _print_files(
        "C", {file: [(line, count > 0) for (line, _), count in lines.items()] for file, lines in counts.items()}
    )


def _pytest(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "pytest", "-q", "-n", "0", *arguments], cwd=ROOT, check=False)


def _print_files(name: str, files: Mapping[str, list[tuple[int, bool]]]) -> bool:
    """Print the files with branches not taken, with their lines, and the total; return whether it reaches `LEAST`."""
    for file, branches in sorted(files.items()):
        missed = [line for line, taken in branches if not taken]
        if missed:
            _print_row(file, len(branches), len(missed))
            print(f"    lines {', '.join(str(line) for line in sorted(set(missed)))}")
    every = [taken for branches in files.values() for _, taken in branches]
    return _print_row(name, len(every), every.count(False))


def _print_row(name: str, total: int, missing: int) -> bool:
    """Print a row of a table; return whether the share of branches taken reaches `LEAST`."""
    share = 100.0 * (total - missing) / max(total, 1)
    print(f"{name:44}{total:8} branches{missing:6} not taken{share:8.1f} %", flush=True)
    return share >= LEAST


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
