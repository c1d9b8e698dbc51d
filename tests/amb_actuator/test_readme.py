"""The README shows the interface as it is and code that runs."""

import re
import shutil
from importlib import util
from pathlib import Path

import pytest

from amb_actuator.actuator import MODEL
from fmi_export.readme import interface_table, with_table

README = Path(util.find_spec("amb_actuator").origin).parent / "README.md"


def test_the_code_of_the_readme_runs_and_prints_what_it_says(build_fmu, run_python, tmp_path):
    shutil.copy(build_fmu(MODEL), tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(blocks) == 1
    result = run_python(blocks[0] + "\nresult = [force, gradient]", cwd=tmp_path)
    force, gradient = result
    assert gradient == pytest.approx(2.376956e6, rel=1e-6)
    assert force == pytest.approx(563.15 + 237.70, abs=0.01)
    assert f"{force:.1f} N" in blocks[0]


def test_rewriting_the_interface_table_changes_nothing():
    text = README.read_text(encoding="utf-8")
    assert with_table(text, interface_table(MODEL)) == text
