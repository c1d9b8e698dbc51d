"""The README shows code that runs and a rotor file that is read."""

from code_blocks import example_of

from rotor_analysis.reduced_rotor import reduced_rotor
from rotor_analysis.rotor_file import load_rotor


def test_example_prints_the_modes_and_critical_speeds_of_the_rig(capsys):
    exec(example_of("rotor_analysis"), {})
    lines = capsys.readouterr().out.strip().splitlines()
    assert lines[0] == "61.52 rad/s, zeta = 0.218, backward"
    assert lines[4].startswith("critical speed 62.5 rad/s: ")
    assert len(lines) == 8


def test_rotor_by_sections_is_a_rotor_file(tmp_path):
    (tmp_path / "pump.toml").write_text(example_of("rotor_analysis", "toml"), encoding="utf-8")
    rotor = load_rotor(tmp_path / "pump.toml")
    z = rotor.shaft.nodes
    assert [z[part.node - 1] for part in (*rotor.bodies, *rotor.bearings, *rotor.sites, *rotor.sensors)] == [
        0.45, 0.1, 0.7, 0.1, 0.12,
    ]  # fmt: skip
    assert [z[node - 1] for node in reduced_rotor(rotor).model.translations] == [0.1, 0.7]
