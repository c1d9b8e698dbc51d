"""Feeds the readers of archives with bytes that atheris chooses by the code they reach: `fuzz_archives.py CORPUS...`.

The first byte says which reader: of zip archives, of an FMU's description, of the structure of an SSP archive.
Anything but a ValueError is a finding.
"""

from __future__ import annotations

import io
import os
import sys
import tempfile
import zipfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["amb_files", "amb_cosim", "fmpy.model_description"]):
    from amb_cosim.cosim.basics import cache
    from amb_cosim.cosim.fmu.fmu_description import read_interface
    from amb_cosim.cosim.ssp.reader import load_ssp
    from amb_files.archive import unpack

FOLDER = Path(tempfile.mkdtemp())
(FOLDER / "cache").mkdir()
cache.cache_folder = lambda: FOLDER / "cache"


def read_zip(data: bytes) -> None:
    (FOLDER / "any.zip").write_bytes(data)
    unpack(FOLDER / "any.zip", FOLDER / "unpacked", "any")


def read_description(data: bytes) -> None:
    (FOLDER / "modelDescription.xml").write_bytes(data)
    read_interface(FOLDER, "one")


def read_structure(data: bytes) -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("SystemStructure.ssd", data)
    (FOLDER / "any.ssp").write_bytes(packed.getvalue())
    load_ssp(FOLDER / "any.ssp")


READERS = (read_zip, read_description, read_structure)


def read_one(data: bytes) -> None:
    if not data:
        return
    try:
        READERS[data[0] % len(READERS)](data[1:])
    except ValueError:
        pass
    finally:
        for folder in (FOLDER / "unpacked", FOLDER / "cache"):
            for place, folders, files in os.walk(folder, topdown=False):
                for name in files:
                    Path(place, name).unlink()
                for name in folders:
                    Path(place, name).rmdir()
        (FOLDER / "cache").mkdir(exist_ok=True)


if __name__ == "__main__":
    atheris.Setup(sys.argv, read_one)
    atheris.Fuzz()
