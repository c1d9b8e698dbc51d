"""C sources in this folder: their text, and a hash of the files and facts of a build."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path

FOLDER = Path(__file__).parent


def digest_of(facts: object, *files: str) -> str:
    """Return a hash, 32 hexadecimal digits, of facts and of files, whose names are relative to this folder."""
    sha = hashlib.sha256(json.dumps(facts).encode())
    for name in files:
        sha.update(name.encode() + b"\0" + (FOLDER / name).read_bytes() + b"\0")
    return sha.hexdigest()[:32]


def texts_of(files: Sequence[str]) -> dict[str, str]:
    """Return the text of files of this folder by their names without folders."""
    return {Path(name).name: (FOLDER / name).read_text(encoding="utf-8") for name in files}
