"""pytest plugin that compiles C code with gcc's branch counters; `of_branches` reads them.

python -m pytest -p tools.coverage.gcc --counters FOLDER tests/native

The same source is compiled in several libraries, which gcovr would list separately; merging its lists takes as many
lines as reading those of gcov.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from fmi_export.building.native.compiler import PLATFORMS

ROOT = Path(__file__).resolve().parents[2]
CALLERS = (  # modules that compile by `compile_library`
    "fmi_export.building.native.engines",
    "fmi_export.building.guard.libraries",
    "amb_cosim.cosim.building.loop_library",
)
OPTIONS = ("-shared", "-fPIC", "-O0", "-std=gnu11", "-fvisibility=hidden", "-ffp-contract=off", "--coverage")
OF_KERNELS = ("-c", "-O2", "-fPIC", "-Wno-override-module")

Branch = tuple[int, int]  # line, and number of the branch there


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--counters", metavar="FOLDER", type=Path, help="compile with gcc and write branch counts there")


def pytest_configure(config: pytest.Config) -> None:
    folder = config.getoption("--counters")
    if folder:
        import importlib

        for caller in CALLERS:
            module = importlib.import_module(caller)
            vars(module)["compile_library"] = _with_counters(module.compile_library, folder.resolve())


def _with_counters(compile_library: Callable[..., bytes], counters: Path) -> Callable[..., bytes]:
    def compile_with_gcc(name: str, sources: Mapping[str, str], target_platform: str) -> bytes:
        if target_platform != "linux64":
            return compile_library(name, sources, target_platform)
        folder = counters / f"{name}-{sha256(repr(sorted(sources.items())).encode()).hexdigest()[:16]}"
        folder.mkdir(parents=True, exist_ok=True)
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        inputs = [file for file in sources if file.endswith(".c")]
        for kernels in (file for file in sources if file.endswith(".ll")):
            zig = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[target_platform][1][0], *OF_KERNELS]
            subprocess.run([*zig, kernels, "-o", f"{kernels}.o"], cwd=folder, check=True)
            inputs.append(f"{kernels}.o")
        subprocess.run(["gcc", *OPTIONS, "-o", "library.so", *inputs, "-lm", "-ldl"], cwd=folder, check=True)
        return (folder / "library.so").read_bytes()

    return compile_with_gcc


def of_branches(counters: Path) -> dict[str, dict[Branch, int]]:
    """Return how often each branch was taken, by C file, in all libraries together."""
    taken: dict[str, dict[Branch, int]] = defaultdict(lambda: defaultdict(int))
    names = {path.read_text(encoding="utf-8"): path for path in ROOT.glob("[lo]*/**/*.[ch]")}
    for notes in sorted(counters.glob("*/*.gcno")):
        command = ["gcov", "--json-format", "--branch-probabilities", "--stdout", notes.name]
        text = subprocess.run(command, cwd=notes.parent, capture_output=True, text=True, check=True).stdout
        for line in text.splitlines():
            for file in json.loads(line)["files"]:
                source = names.get((notes.parent / file["file"]).read_text(encoding="utf-8"))
                if source is not None:
                    _add(file, taken["/".join(source.parts[-2:])])
    return taken


def _add(file: Mapping[str, Any], taken: dict[Branch, int]) -> None:
    for line in file["lines"]:
        for k, branch in enumerate(line["branches"]):
            taken[line["line_number"], k] += branch["count"]
