"""Tests under other arithmetic: `python -m tests.arithmetic [SETTING ...] [--keep FOLDER] [-- pytest's arguments]`.

Sums in another order, fused or not, change last bits from one processor to another. Each setting lets BLAS, numpy,
numba and the C library choose instructions of another one, from empty caches; a test that then changes its verdict, or
comes near its tolerance, hangs on bits. All settings are run by default, but those that this processor cannot; `--keep`
adds what was noted to that of earlier runs.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
NEAR = 2.0 / 3.0  # of a tolerance
MOVED = 0.01  # of a tolerance: what moves by less does not hang on bits

OLD_LIBM = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"
# By name: cores of OpenBLAS and of numba, what this processor must have, levels of numpy that are off, the C library.
SETTINGS: Mapping[str, Mapping[str, str]] = {
    "own": {},
    "oldest": {
        "OPENBLAS_CORETYPE": "Prescott",
        "NUMBA_CPU_NAME": "generic",
        "NUMBA_CPU_FEATURES": "",
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX2 FMA3 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR",
        "GLIBC_TUNABLES": OLD_LIBM,
    },
    "Haswell": {
        "OPENBLAS_CORETYPE": "Haswell",
        "NUMBA_CPU_NAME": "haswell",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR",
    },
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX", "NUMBA_CPU_NAME": "skylake-avx512"},
    "Zen": {
        "OPENBLAS_CORETYPE": "Zen",
        "NUMBA_CPU_NAME": "znver2",
        "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR",
    },
}
NEEDS = {"Haswell": "AVX2", "Zen": "AVX2", "SkylakeX": "AVX512F"}


def main() -> int:
    """Run the tests under the settings that are named; print what hangs on bits and return 1 if a test does."""
    parser = argparse.ArgumentParser(prog="python -m tests.arithmetic", description="Run tests under other arithmetic.")
    parser.add_argument("settings", nargs="*", metavar="SETTING", help=f"of {', '.join(SETTINGS)}; all by default")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where notes of runs are, and are kept")
    arguments = sys.argv[1:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    chosen = parser.parse_args(arguments[:split])
    unknown = set(chosen.settings) - set(SETTINGS)
    if unknown:
        parser.error(f"there is no setting {', '.join(sorted(unknown))}; there are {', '.join(SETTINGS)}")
    with tempfile.TemporaryDirectory() as folder:
        notes = chosen.keep or Path(folder, "notes")
        codes = [run(name, notes / name, arguments[split + 1 :]) for name in chosen.settings or SETTINGS]
        suspects = compare({path.name: read_notes(path) for path in sorted(notes.iterdir())})
    return int(any(codes) or suspects > 0)


def run(name: str, notes: Path, arguments: list[str]) -> int:
    """Run the tests under one setting, which leaves its notes in a folder; return pytest's exit code."""
    if NEEDS.get(name, "SSE2") not in _features():
        print(f"{name}: left out, this processor has no {NEEDS[name]}")
        return 0
    changes = dict(SETTINGS[name])
    if "NPY_DISABLE_CPU_FEATURES" in changes:  # numpy takes no names that it does not know
        levels = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
        changes["NPY_DISABLE_CPU_FEATURES"] = " ".join(
            level for level in changes["NPY_DISABLE_CPU_FEATURES"].split() if level in levels
        )
    notes.mkdir(parents=True, exist_ok=True)
    # Without files of byte code in the new folder, every process would compile all that it imports.
    dropped = {"PYTHONDONTWRITEBYTECODE"}.union(*SETTINGS.values())
    own = {key: value for key, value in os.environ.items() if key not in dropped}
    command = [sys.executable, "-m", "pytest", "-p", "tests.arithmetic.margins", "-o", "enable_assertion_pass_hook=true"]
    print(f"\n== {name}: {changes}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        caches = {
            "NUMBA_CACHE_DIR": str(Path(folder, "numba")),
            "PYTHONPYCACHEPREFIX": str(Path(folder, "pycache")),
            "XDG_CACHE_HOME": str(Path(folder, "cache")),
        }
        settings = {"MARGINS_FOLDER": str(notes.resolve()), "CI": "true"}  # no random examples, which would differ too
        return subprocess.run(
            [*command, *arguments], cwd=ROOT, env=own | changes | caches | settings, check=False
        ).returncode


def read_notes(folder: Path) -> dict[str, dict[str, float]]:
    """Return by test how near each comparison came to its limit, 1 at the limit; `failed` is that of a test."""
    notes: dict[str, dict[str, float]] = {}
    for file in sorted(folder.iterdir(), key=lambda file: file.stat().st_mtime):
        notes |= json.loads(file.read_text(encoding="utf-8"))
    return notes


def compare(found: Mapping[str, Mapping[str, Mapping[str, float]]]) -> int:
    """Print tests whose verdict changes, and comparisons that move and come near their limits; return how many tests."""
    suspects = 0
    for test in sorted(set().union(*found.values())):
        by_setting = {name: tests[test] for name, tests in found.items() if test in tests}
        failed = [name for name, margins in by_setting.items() if "failed" in margins]
        rows = []
        for place in sorted(set().union(*by_setting.values()) - {"failed"}):
            values = {name: margins[place] for name, margins in by_setting.items() if place in margins}
            spread = max(values.values()) - min(values.values())
            if max(values.values()) > NEAR and spread > MOVED:
                rows.append(f"    {place}: " + ", ".join(f"{name} {value:.3f}" for name, value in values.items()))
        if failed or rows:
            suspects += 1
            print("\n".join([f"{test}: {'fails under ' + ', '.join(failed) if failed else 'near its limit'}", *rows]))
    print(f"{suspects} tests hang on bits, of {len(set().union(*found.values()))} under {len(found)} settings")
    return suspects


def _features() -> list[str]:
    simd = np.show_config(mode="dicts")["SIMD Extensions"]
    return [*simd["baseline"], *simd["found"], *_cpu_flags()]


def _cpu_flags() -> list[str]:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return []
    flags = next((line for line in text.splitlines() if line.startswith("flags")), "")
    return flags.upper().split()


if __name__ == "__main__":
    sys.exit(main())
