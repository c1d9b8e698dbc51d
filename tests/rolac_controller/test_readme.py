"""The README shows code that runs."""

import re
from pathlib import Path

import pytest

import rolac_controller

README = Path(rolac_controller.__file__).parent / "README.md"


def test_example_in_the_readme_finds_the_vibration_it_made(run_python, tmp_path):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    amplitude, phase = run_python(example + "\nresult = [float(amplitude), float(phase)]", cwd=tmp_path)
    assert amplitude == pytest.approx(1e-4, rel=1e-6)
    assert phase == pytest.approx(-1.0471975511965976, abs=1e-6)
