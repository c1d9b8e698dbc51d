"""The pages on other tools: their programs run with an archive of the rig."""

import re
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from command_line import run_command, run_program

PAGES = Path(__file__).parents[2] / "docs" / "how-to" / "tools"
SCENARIO = """
base = "fig4_9"
coupling = "jacobi"
settle_cycles = 0
end_cycle = 3
event = []
"""


ONE_TBB = """import ctypes, sys, contextlib  # ecos needs it: the wheel's, which no loader finds, or else the system's
with contextlib.suppress(OSError):
    ctypes.CDLL(f"{sys.prefix}/lib/libtbb.so.12", ctypes.RTLD_GLOBAL)
"""


def programs(page):
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    return [block for block in re.findall(r"```python[^\n]*\n(.*?)```", text, re.DOTALL) if "rig.ssp" in block]


@pytest.fixture(scope="session")
def folder(create_once):
    """A folder with the archive that `export-ssp` writes for a parallel master without Enumerations."""

    def fill(folder):
        (folder / "parallel.toml").write_text(SCENARIO, encoding="utf-8")
        run_command("export-ssp", "parallel.toml", "-o", "rig.ssp", "--integers", cwd=folder)

    return create_once("pages", fill)


@pytest.mark.slow
@pytest.mark.parametrize(("page", "package"), [("libcosim", "libcosimpy"), ("ecos", "ecospy")])
def test_the_program_of_a_page_runs(page, package, folder, tmp_path):
    """That of FMPy is among the pages of tests/docs/test_code_blocks.py."""
    if find_spec(package) is None:
        pytest.skip(f"{package} is not installed (extra: peers)")
    (program,) = programs(page)
    shutil.copy(folder / "rig.ssp", tmp_path)
    (tmp_path / "program.py").write_text((ONE_TBB if page == "ecos" else "") + program, encoding="utf-8")
    done = run_program(sys.executable, "program.py", cwd=tmp_path)
    numbers = [float(text) for text in re.findall(r"-?\d+\.\d+e-\d+", done.stdout)]
    assert numbers
    assert all(0.0 < abs(x) < 0.1e-3 for x in numbers), "the rotor levitates"
