"""Production code passes values as objects; temporary files are for other programs, archives and atomic writing."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("applications", "fmus", "libraries", "orchestrator", "packs")
ALLOWED = {
    "libraries/amb_files/temporary_folders.py": "makes them",
    "libraries/amb_files/atomic.py": "a file appears complete or not at all",
    "libraries/amb_files/user_cache.py": "a cache where the user's folder cannot be written",
    "libraries/fmi_export/building/experiment.py": "FMPy simulates an FMU",
    "libraries/fmi_export/building/native/compiler.py": "zig compiles sources",
    "libraries/fmi_export/building/native/lowering.py": "numba compiles in a process of its own",
    "orchestrator/amb_cosim/cosim/building/cache.py": "FMUs are unpacked for the dynamic loader",
    "applications/amb_analysis/measured/uff_data.py": "pyuff reads a file",
    "applications/amb_sweeps/store.py": "a group of a store appears complete or not at all",
}


def test_temporary_files_are_for_other_programs_and_archives():
    uses = re.compile(r"\btempfile\b|\bmkdtemp\b|\btemporary_folder\b")
    files = [file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py")]
    using = {f.relative_to(ROOT).as_posix() for f in files if uses.search(f.read_text(encoding="utf-8"))}
    assert using == set(ALLOWED)
