"""A rotor file with one mistake: one message that names the file and the key, and exit code 2."""

from __future__ import annotations

import copy
import math
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
import tomli_w
from click.testing import CliRunner

from amb_cosim.commands.cli import main

VALID = """
name = "pump"
[shaft]
theory = "timoshenko"
shear = "cowper"
mass_matrix = "consistent"
material = "steel"
[[shaft.sections]]
length = 0.3
diameter = 0.05
diameter_end = 0.06
[[shaft.sections]]
length = 0.4
diameter = 0.06
inner_diameter = 0.02
material = "bronze"
[[shaft.sleeves]]
begin = 0.1
end = 0.2
diameter = 0.08
inner_diameter = 0.055
[materials.steel]
youngs_modulus = 2.1e11
density = 7800.0
poissons_ratio = 0.3
[materials.bronze]
youngs_modulus = 1.1e11
density = 8800.0
poissons_ratio = 0.34
[damping]
mass = 1.0
stiffness = 1e-5
modal = [0.01, 0.02]
loss_factor = 0.004
rotating = 0.5
[mesh]
modes = 4
accuracy = 0.01
[[bodies]]
name = "impeller"
z = 0.35
mass = 6.0
radius = 0.1
width = 0.03
unbalance = true
[[bodies]]
name = "coupling"
node = 3
mass = 1.0
diametral_inertia = 0.01
polar_inertia = 0.02
[[bearings]]
name = "mb1"
z = 0.05
stiffness = 1e6
damping = [[100.0, 5.0], [-5.0, 100.0]]
[[bearings]]
name = "mb2"
z = 0.65
[[bearings.at_speed]]
speed = 0.0
stiffness = 1e6
[[bearings.at_speed]]
speed = 500.0
stiffness = 2e6
damping = 10.0
[[sites]]
name = "rb1"
z = 0.05
bearing = "mb1"
[[sensors]]
name = "left"
node = 1
x = "s1"
y = "s2"
[reduction]
modes = 2
accuracy = 0.01
"""
DATA = tomllib.loads(VALID)
REQUIRED = {
    "name", "shaft", "length", "diameter", "youngs_modulus", "density", "poissons_ratio", "mass", "width",
    "diametral_inertia", "polar_inertia", "speed", "begin", "end",
}  # fmt: skip

Path = tuple[str | int, ...]


def leaves(value: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Every value that is no table, with its path; tensors are one value."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from leaves(inner, (*path, key))
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for k, inner in enumerate(value):
            yield from leaves(inner, (*path, k))
    else:
        yield path, value


def tables(value: Any, path: Path = ()) -> Iterator[Path]:
    """The path of every table."""
    if isinstance(value, dict):
        if path[-1:] != ("materials",):
            yield path
        for key, inner in value.items():
            yield from tables(inner, (*path, key))
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from tables(inner, (*path, k))


def changed(path: Path, value: Any = None, *, delete: bool = False) -> dict[str, Any]:
    """The valid file with one value replaced, added or taken away."""
    data = copy.deepcopy(DATA)
    inner: Any = data
    for key in path[:-1]:
        inner = inner[key]
    if delete:
        del inner[path[-1]]
    else:
        inner[path[-1]] = value
    return data


def mutations() -> Iterator[tuple[str, Path, dict[str, Any]]]:
    for path, value in leaves(DATA):
        where = ".".join(map(str, path))
        if isinstance(value, str):
            yield f"{where} a number", path, changed(path, 7)
            yield f"{where} of another kind", path, changed(path, [] if path == ("name",) else "no such thing")
        elif isinstance(value, bool):
            yield f"{where} a text", path, changed(path, "yes")
        else:
            yield f"{where} a text", path, changed(path, "much")
            yield f"{where} not a number", path, changed(path, math.nan)
            if path[-1] not in ("stiffness", "damping", "speed", "poissons_ratio"):
                yield f"{where} negative", path, changed(path, -1.0 if isinstance(value, float) else -1)
        if path[-1] in REQUIRED and path[0] != "damping":
            yield f"{where} missing", path, changed(path, delete=True)
    for path in tables(DATA):
        yield f"{'.'.join(map(str, path))} unknown key", (*path, "colour"), changed((*path, "colour"), 1.0)


# Mistake between values: where, what, and how the message begins.
OTHERS: dict[str, tuple[str, Any, str]] = {
    "part before the shaft": ("sites.0.z", -0.1, "sites[0].z (rb1) = -0.1 m"),
    "material that there is not": ("shaft.material", "steal", "shaft.material = 'steal' is not one of"),
    "material of a section": ("shaft.sections.1.material", "brass", "shaft.material = 'brass' is not one of"),
    "one master": ("reduction", {"masters": [1]}, "reduction.masters = [1]"),
    "parts a hair apart": ("sites.0.z", 0.05001, "nodes = 0.05 m, 0.05001 m"),
    "shaft as thick as a galaxy": ("shaft.sections.0.diameter", 1e30, "shaft.sections[0].diameter = 1e+30 m"),
    "bearing stiffer than anything": ("bearings.0.stiffness", 1e30, "bearings[0].stiffness (mb1)"),
    "no sections": ("shaft.sections", [], "shaft.sections = []"),
    "a shaft by nodes too": ("shaft.nodes", [0.0, 1.0], "unknown key shaft.nodes"),
    "disc with inertia": ("bodies.0.polar_inertia", 1.0, "unknown key bodies[0].polar_inertia (impeller)"),
    "section that is a number": ("shaft.sections.0", 3, "shaft.sections[0] = 3"),
    "bodies that are a table": ("bodies", {"name": "impeller"}, "bodies = a table"),
}
CASES = {name: (path, data) for name, path, data in mutations()}


def shown(tmp_path, data: dict[str, Any]):
    (tmp_path / "pump.toml").write_text(tomli_w.dumps(data), encoding="utf-8")
    return CliRunner().invoke(main, ["rotor", "show", str(tmp_path / "pump.toml")])


def test_file_without_mistake_is_shown(tmp_path):
    done = shown(tmp_path, DATA)
    assert done.exit_code == 0, done.output
    assert len(CASES) > 100


@pytest.mark.parametrize("case", CASES)
def test_mistake_is_named_with_file_and_key_in_one_message(tmp_path, case):
    path, data = CASES[case]
    done = shown(tmp_path, data)
    assert done.exit_code == 2, done.output
    (line,) = done.output.splitlines()
    assert line.startswith(f"amb-cosim: rotor file {tmp_path / 'pump.toml'}: ")
    assert str(path[-1]) in line.split(".toml: ")[1]


@pytest.mark.parametrize("case", OTHERS)
def test_mistake_between_values_is_named_at_one_of_them(tmp_path, case):
    where, value, expected = OTHERS[case]
    path = tuple(int(key) if key.isdigit() else key for key in where.split("."))
    done = shown(tmp_path, changed(path, value))
    assert done.exit_code == 2, done.output
    (line,) = done.output.splitlines()
    assert line.startswith(f"amb-cosim: rotor file {tmp_path / 'pump.toml'}: ")
    assert expected in line
