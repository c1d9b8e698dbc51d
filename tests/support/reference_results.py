"""FMUs with reference results (FMI-LS-REF) for `verify`."""

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path

from amb_cosim.cosim.building.cache import unpacked
from amb_cosim.cosim.verify.reference_experiments import read_experiments
from amb_cosim.cosim.verify.verification import Verified
from amb_cosim.cosim.verify.verification_process import _verified

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"


def verified_with(fmu: Path, path: Path, files: Mapping[str, str]) -> Verified:
    """Return the only result of an FMU copied to `path` with these files; `one.exp`, or else `out.csv`, is listed."""
    role, kind = ("experiment", "application/x-ma-hs-experiments") if "one.exp" in files else ("result", "text/csv")
    source = "one.exp" if "one.exp" in files else "out.csv"
    related = f'<Related type="{kind}" source="{source}" role="{role}"/>'
    shutil.copy(fmu, path)
    with zipfile.ZipFile(path, "a") as archive:
        for name, text in {"fmi-ls-manifest.xml": f"<m>{related}</m>", **files}.items():
            archive.writestr(f"{FOLDER}/{name}", text)
    (verified,) = verify_here(path)
    return verified


def verify_here(path: Path) -> list[Verified]:
    """Do as `amb_cosim.verify`, without a process of its own."""
    folder = unpacked(path, f"FMU {path}")
    return [_verified(folder, each) for each in read_experiments(folder)]


def table(columns: str, rows: list[object]) -> str:
    """Return a table of rows from 0 s in steps of 0.1 s."""
    return "\n".join([f"time,{columns}", *(f"{0.1 * k:.1f},{row}" for k, row in enumerate(rows))])
