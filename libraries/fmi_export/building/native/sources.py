"""The C sources in this folder: their texts, and a hash of the files and facts of a build."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

FOLDER = Path(__file__).parent


def digest_of(facts: object, *files: str) -> str:
    """Return a hash of 32 hexadecimal digits for facts and files; file names are relative to this folder."""
    sha = hashlib.sha256(json.dumps(facts).encode())
    for name in files:
        sha.update(name.encode() + b"\0" + (FOLDER / name).read_bytes() + b"\0")
    return sha.hexdigest()[:32]


def texts_of(files: Sequence[str]) -> dict[str, str]:
    """Return the texts of files of this folder, by their names without subfolders."""
    return {Path(name).name: (FOLDER / name).read_text(encoding="utf-8") for name in files}
