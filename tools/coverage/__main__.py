"""Branch coverage of kernels, slaves and master: `python -m tools.coverage [kernels] [host] [c]`, all by default.

`kernels`: the models, compiled, with notes of their branches. `host`: what is Python in an FMU, and the master, by
coverage.py. `c`: what is C, compiled by gcc. The exit code is the number of parts below 95 %.
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
    # Here coverage.py handles SIGTERM.
    "--deselect=tests/cosim/test_interruption.py::test_sigterm_ends_a_program_that_uses_the_package_as_before",
]
PARTS = {  # of what is Python
    "master": "orchestrator/amb_cosim/cosim",
    "what builds FMUs": "libraries/fmi_export/building",
    "models, and flavour python": "libraries/fmi_export",
}
C = [
    *("tests/native", "tests/fmi_export", "tests/cosim/test_compiled.py"),
    # The counters are exported too.
    "--deselect=tests/native/test_exports.py::test_the_linux_library_exports_the_fmi_functions_alone",
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
    report = folder / "kernels.json"
    _pytest("-p", "tools.coverage.kernels", "--branches", str(report), *MODELS)
    result = json.loads(report.read_text(encoding="utf-8"))
    return _tell_all("kernels", {file: [(line, taken) for line, taken in lines] for file, lines in result.items()})


def _host(folder: Path) -> bool:
    # In a new cache kernels are compiled, which runs what compiles them.
    environment = os.environ | {"COVERAGE_FILE": str(folder / "data"), "NUMBA_CACHE_DIR": str(folder / "numba")}

    def coverage(*arguments: str) -> None:
        subprocess.run([sys.executable, "-m", "coverage", *arguments], cwd=ROOT, env=environment, check=False)

    coverage("run", "-m", "pytest", "-q", "-n", "0", *HOST)
    coverage("combine", "--quiet")
    coverage("json", "--quiet", f"-o{folder / 'report.json'}")
    files = json.loads((folder / "report.json").read_text(encoding="utf-8"))["files"]
    enough = []
    for name, start in PARTS.items():
        mine = {file: files.pop(file) for file in list(files) if file.startswith(start)}
        result = {
            file: [
                *((line, True) for line, _ in branches["executed_branches"]),
                *((line, False) for line, _ in branches["missing_branches"]),
            ]
            for file, branches in mine.items()
        }
        enough.append(_tell_all(name, result))
    return all(enough)


def _c(folder: Path) -> bool:
    _pytest("-p", "tools.coverage.gcc", "--counters", str(folder / "counters"), *C)
    result = of_branches(folder / "counters")
    return _tell_all(
        "C", {file: [(line, count > 0) for (line, _), count in lines.items()] for file, lines in result.items()}
    )


def _pytest(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "pytest", "-q", "-n", "0", *arguments], cwd=ROOT, check=False)


def _tell_all(name: str, files: Mapping[str, list[tuple[int, bool]]]) -> bool:
    """Print the files that have branches not taken, with their lines, and the sum; return whether it is enough."""
    for file, branches in sorted(files.items()):
        missed = [line for line, taken in branches if not taken]
        if missed:
            _tell(file, len(branches), len(missed))
            print(f"    lines {', '.join(str(line) for line in sorted(set(missed)))}")
    every = [taken for branches in files.values() for _, taken in branches]
    return _tell(name, len(every), every.count(False))


def _tell(name: str, total: int, missing: int) -> bool:
    """Print a row of a table; return whether it is enough."""
    share = 100.0 * (total - missing) / max(total, 1)
    print(f"{name:44}{total:8} branches{missing:6} not taken{share:8.1f} %", flush=True)
    return share >= LEAST


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
