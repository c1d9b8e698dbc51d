"""Tests under other arithmetic: `python -m tools.arithmetic [SETTING ...] [--keep FOLDER] [-- pytest's arguments]`.

A test that changes its verdict under one of the settings, or comes near its tolerance, hangs on last bits. `--keep`
adds what was noted to that of earlier runs.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from tools.arithmetic.settings import chosen_settings, environment_of

ROOT = Path(__file__).resolve().parents[2]
NEAR = 2.0 / 3.0  # of a tolerance
MOVED = 0.01  # of a tolerance: what moves by less does not hang on bits

Notes = Mapping[str, Mapping[str, float]]  # by test and place: how near it came to its limit, 1 at the limit


def main(arguments: list[str]) -> int:
    """Run the tests under the settings that are named; print what hangs on bits and return 1 if a test does."""
    parser = argparse.ArgumentParser(prog="python -m tools.arithmetic", description="Run tests under other arithmetic.")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where notes of runs are, and are kept")
    split = arguments.index("--") if "--" in arguments else len(arguments)
    names, values = chosen_settings(parser, arguments[:split])
    with tempfile.TemporaryDirectory() as folder:
        notes = values.keep or Path(folder)
        codes = [run(name, notes / name, arguments[split + 1 :]) for name in names]
        suspects = compare({path.name: read_notes(path) for path in sorted(notes.iterdir())})
    return int(any(codes) or suspects > 0)


def run(name: str, notes: Path, arguments: list[str]) -> int:
    """Run the tests under one setting, which leaves its notes in a folder; return pytest's exit code."""
    notes.mkdir(parents=True, exist_ok=True)
    print(f"\n== {name}", flush=True)
    noting = ["-p", "tools.arithmetic.margins", "-o", "enable_assertion_pass_hook=true"]
    with environment_of(name) as environment:
        # No random examples: they would differ too.
        environment |= {"MARGINS_FOLDER": str(notes.resolve()), "CI": "true"}
        command = [sys.executable, "-m", "pytest", *noting, *arguments]
        return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


def read_notes(folder: Path) -> Notes:
    """Return the notes that the processes of a run left; `failed` is the place of a test that failed."""
    notes: dict[str, dict[str, float]] = {}
    for file in sorted(folder.iterdir(), key=lambda file: file.stat().st_mtime):
        notes |= json.loads(file.read_text(encoding="utf-8"))
    return notes


def compare(found: Mapping[str, Notes]) -> int:
    """Print tests that fail, and comparisons that move and come near their limits; return how many tests those are."""
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


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
