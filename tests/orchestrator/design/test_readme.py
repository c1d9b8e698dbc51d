"""The README of the package shows code that runs and names every file."""

import re
from pathlib import Path

from amb_cosim import design

FOLDER = Path(design.__file__).parent
README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_example_in_the_readme_prints_the_design_figures(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})
    lines = capsys.readouterr().out.strip().splitlines()
    assert lines[0].startswith("K_s = 2392.5 N/mm")  # the rig's bias currents, thesis section 2.4
    assert len(lines) == 3


def test_readme_names_every_file_of_the_package():
    files = {file.name for file in FOLDER.glob("*.py")} - {"__init__.py"}
    assert {name for name in files if f"`{name}`" not in README} == set()
