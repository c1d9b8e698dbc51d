"""Mutants of the files whose faults would be hardest to notice: `python -m tools.mutation [NAME ...]`, all by default.

A name may be followed by further options of `plugin`, as in `python -m tools.mutation friction --mutants 17,23`.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CONTACT = tuple(
    f"tests/rotor_contact/test_{name}.py"
    for name in (
        *("contact", "contact_equations", "friction", "stribeck", "impact", "sites", "geometry", "compliant"),
        *("collocation", "pieces", "events", "path", "touchdown_closed_forms", "touchdown_two_bodies"),
        *("touchdown_many_sites", "free_flight", "speed", "energy", "robustness", "interface", "shaft_damping"),
        *("bodies", "cut_pieces", "steps_of_any_law", "seals", "force_between_samples"),
    )
)
TARGETS = {
    **{
        place.rpartition("/")[2]: (f"fmus/rotor_contact/{place}.py", *CONTACT)
        for place in (
            *("contact/friction", "contact/site", "contact/path", "contact/constraints", "contact/impact"),
            *("contact/bodies", "substeps/substeps", "matrix_step", "pieces/piece", "pieces/piece_solution"),
            *("pieces/piece_contact", "pieces/piece_ports", "pieces/piece_events"),
            *("pieces/piece_cut", "pieces/piece_energy"),
            "whole_steps/collocation",
        )
    },
    "fourier": ("fmus/rolac_controller/fourier.py", "tests/rolac_controller/test_fourier.py"),
    "master": (
        "orchestrator/amb_cosim/cosim/master/master.py",
        "tests/cosim/test_master.py",
        "tests/cosim/test_iteration.py",
    ),
    "iteration": ("orchestrator/amb_cosim/cosim/master/iteration.py", "tests/cosim/test_iteration.py"),
    "compiled": ("orchestrator/amb_cosim/cosim/master/compiled.py", "tests/cosim/test_compiled.py"),
}


def main(arguments: list[str]) -> int:
    """Run the named campaigns, or all, in sequence; return how many failed to run."""
    names = [argument for argument in arguments if argument in TARGETS]
    options = [argument for argument in arguments if argument not in TARGETS]
    codes = []
    for name in names or TARGETS:
        file, *tests = TARGETS[name]
        command = [sys.executable, "-m", "pytest", "-p", "tools.mutation.plugin", "-n", "0", "-q", "-s"]
        codes.append(subprocess.run([*command, "--mutate", file, *tests, *options], cwd=ROOT, check=False).returncode)
    return sum(code != 0 for code in codes)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
