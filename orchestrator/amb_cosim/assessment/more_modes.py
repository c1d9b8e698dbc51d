"""The machine with more modes of its rotor than the reduction of its rotor file keeps."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import tomli_w

from amb_cosim.assessment.subject import Subject
from amb_files.toml import read_toml
from rotor_analysis.packaged_rotors import rotor_path
from rotor_analysis.reduced_rotor import reduced_rotor


def kept_modes(subject: Subject) -> tuple[int, int]:
    """Return how many modes in a plane of motion the reduction keeps besides its planes, and how many there are."""
    model = reduced_rotor(subject.rotor).model
    planes = len(model.translations)
    return model.size // 2 - planes, 2 * len(subject.rotor.shaft.nodes) - planes


@contextmanager
def with_modes(subject: Subject, modes: int) -> Iterator[Subject]:
    """Yield the machine whose rotor keeps its planes and a number of modes (R. R. Craig, M. C. C. Bampton)."""
    source = rotor_path(subject.prepared.scenario.rotor)
    content = read_toml(source, "rotor file")
    masters = {key: value for key, value in content.get("reduction", {}).items() if key == "masters"}
    content["reduction"] = masters | {"method": "craig_bampton", "modes": modes}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{subject.rotor.name}.toml"
        path.write_text(tomli_w.dumps(content), encoding="utf-8")
        yield replace(subject, file=subject.file.model_copy(update={"rotor": str(path)}))
