"""The README of the package shows code that runs."""

import math
import re
from pathlib import Path

from running_actuator import K

from amb_cosim import design

FOLDER = Path(design.__file__).parent
README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_example_in_the_readme_prints_the_design_figures(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})
    lines = capsys.readouterr().out.strip().splitlines()
    assert lines[0].startswith("K_s = 2392.5 N/mm")  # the rig's bias currents, thesis section 2.4
    static = math.sqrt(4.3**2 + 354.0 / K) - 4.3  # K ((I_b + I_s)^2 - I_b^2) = 354 N; saturation adds less than 1 mA
    assert lines[1:] == [f"I_s = {static:.3f} A carries 354 N"]
