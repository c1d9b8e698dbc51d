"""The README shows code that runs and a rotor file that is read."""

import re
from pathlib import Path

import rotor_analysis
from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor_file import load_rotor

FOLDER = Path(rotor_analysis.__file__).parent
README = (FOLDER / "README.md").read_text(encoding="utf-8")


def test_example_prints_the_modes_and_critical_speeds_of_the_rig(capsys):
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})
    lines = capsys.readouterr().out.strip().splitlines()
    assert lines[0] == "61.52 rad/s, zeta = 0.218, backward"
    assert lines[4].startswith("critical speed 62.5 rad/s: ")
    assert len(lines) == 8


def test_rotor_by_sections_is_a_rotor_file(tmp_path):
    (example,) = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)
    (tmp_path / "pump.toml").write_text(example, encoding="utf-8")
    rotor = load_rotor(tmp_path / "pump.toml")
    z = rotor.shaft.nodes
    assert [z[part.node - 1] for part in (*rotor.bodies, *rotor.bearings, *rotor.sites, *rotor.sensors)] == [
        0.45, 0.1, 0.7, 0.1, 0.12,
    ]  # fmt: skip
    assert [z[node - 1] for node in reduced_rotor(rotor).model.translations] == [0.1, 0.7]
