"""Tests under other arithmetic: `python -m tools.arithmetic [SETTING ...] [--keep FOLDER] [-- pytest's arguments]`.

A test that fails under some settings only, or comes near its tolerance, depends on last bits. `--keep` adds the notes
to those of earlier runs.
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
MOVED = 0.01  # of a tolerance; a comparison that moves by less does not depend on last bits

Notes = Mapping[str, Mapping[str, float]]  # by test and place: error over tolerance, 1 at the limit


def main(arguments: list[str]) -> int:
    """Run the tests under the named settings, print those that depend on last bits; return 1 if any does or fails."""
    parser = argparse.ArgumentParser(prog="python -m tools.arithmetic", description="Run tests under other arithmetic.")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="add the notes to those in this folder")
    split = arguments.index("--") if "--" in arguments else len(arguments)
    names, values = chosen_settings(parser, arguments[:split])
    with tempfile.TemporaryDirectory() as folder:
        notes = values.keep or Path(folder)
        codes = [run(name, notes / name, arguments[split + 1 :]) for name in names]
        suspects = compare({path.name: read_notes(path) for path in sorted(notes.iterdir())})
    return int(any(codes) or suspects > 0)


def run(name: str, notes: Path, arguments: list[str]) -> int:
    """Run the tests under a setting, write the notes into a folder, and return pytest's exit code."""
    notes.mkdir(parents=True, exist_ok=True)
    print(f"\n== {name}", flush=True)
    plugin = ["-p", "tools.arithmetic.margins", "-o", "enable_assertion_pass_hook=true"]
    with environment_of(name) as environment:
        # No random examples: they would differ too.
        environment |= {"MARGINS_FOLDER": str(notes.resolve()), "CI": "true"}
        command = [sys.executable, "-m", "pytest", *plugin, *arguments]
        return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode


def read_notes(folder: Path) -> Notes:
    """Return the notes that the processes of a run left; `failed` is the place of a test that failed."""
    notes: dict[str, dict[str, float]] = {}
    for file in sorted(folder.iterdir(), key=lambda file: file.stat().st_mtime):
        notes |= json.loads(file.read_text(encoding="utf-8"))
    return notes


def compare(notes: Mapping[str, Notes]) -> int:
    """Print tests that fail, or whose comparisons move and come near their limits; return how many there are."""
    suspects = 0
    for test in sorted(set().union(*notes.values())):
        by_setting = {name: tests[test] for name, tests in notes.items() if test in tests}
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
    print(f"{suspects} of {len(set().union(*notes.values()))} tests depend on bits, under {len(notes)} settings")
    return suspects


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
