"""The rotor that co-simulations of a machine have: its stages act in it as seals do, with coefficients over the speed.

A plant's mass does not depend on the speed: that of a stage is the one at the largest speed of the machine.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import tomli_w

from amb_cosim.assessment.machine_file import WHIRL, CompressorStage, MachineFile
from amb_files.toml import read_toml
from rotor_analysis.packaged_rotors import rotor_path

PARTS = ("bodies", "bearings", "seals", "sites", "sensors")


def machine_with_stages(
    file: MachineFile, stages: Sequence[CompressorStage], rotor: str | None, folder: tempfile.TemporaryDirectory[str]
) -> MachineFile:
    """Return a machine whose rotor file, written into a folder, has stages by the better calculation as seals.

    Parameters
    ----------
    file, stages, rotor
        The machine, its stages at planes of the plant, and its rotor: a file, or the name of one of a pack.
    folder
        Where the rotor file is written; it must stay for as long as the machine is used.
    """
    if not stages:
        return file
    source = rotor_path(rotor)
    content = with_stages(read_toml(source, "rotor file"), stages, file.speed.highest)
    path = Path(folder.name) / source.name
    path.write_text(tomli_w.dumps(content), encoding="utf-8")
    return file.model_copy(update={"rotor": str(path)})


def with_stages(content: dict[str, Any], stages: Sequence[CompressorStage], Omega: float) -> dict[str, Any]:
    """Return a rotor file's content with stages as seals, where its parts of those names are.

    Parameters
    ----------
    content, stages
        The rotor file, and stages at parts that it has.
    Omega
        Largest speed (rad/s), at which the anticipated coupling and the mass are taken.
    """
    parts = {part["name"]: part for kind in PARTS for part in content.get(kind, ())}
    seals, names = list(content.get("seals", ())), set(parts)
    for stage in stages:
        at = {key: parts[stage.at][key] for key in ("node", "z") if key in parts[stage.at]}
        free = (f"{stage.at}_stage{k or ''}" for k in range(len(names) + 1))
        name = next(item for item in free if item not in names)
        names.add(name)
        seals.append({"name": name, **at, **_coefficients(stage, Omega)})
    return {**content, "seals": seals}


def _coefficients(stage: CompressorStage, Omega: float) -> dict[str, Any]:
    """Return the keys of a stage as a seal."""
    result = stage.coefficients()
    if result is None:
        return {"stiffness": (stage.level_two(Omega) * WHIRL).tolist()}
    mass = result.at(Omega)[2].tolist()
    if not result.at_speed:
        K, C, _ = result.at(Omega)
        return {"stiffness": K.tolist(), "damping": C.tolist(), "mass": mass}
    rows = []
    for table in result.at_speed:
        K, C, _ = result.at(table.speed)
        rows.append({"speed": table.speed, "stiffness": K.tolist(), "damping": C.tolist(), "mass": mass})
    return {"at_speed": rows}
