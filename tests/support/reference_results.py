"""FMUs with reference results (FMI-LS-REF) for `verify`."""

import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path

import amb_cosim
from amb_cosim.cosim.verify.verification import Verified

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
    (verified,) = amb_cosim.verify(path)
    return verified


def table(columns: str, rows: list[object]) -> str:
    """Return a table of rows from 0 s in steps of 0.1 s."""
    return "\n".join([f"time,{columns}", *(f"{0.1 * k:.1f},{row}" for k, row in enumerate(rows))])
