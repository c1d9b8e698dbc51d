"""The host in C: its arguments for an FMU, and its answers to a program."""

import subprocess
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

SUPPORT = Path(__file__).parent
HEADERS = SUPPORT.parents[2] / "libraries" / "fmi_export" / "building" / "native" / "fmi_headers"

Answers = tuple[list[list[str]], str]  # the words of each line, and the log


def binary_of(folder: Path, platform: str | None = None) -> tuple[Path, str, str]:
    """Return library, guid and location of the resources of an extracted FMU, by default for this machine."""
    from fmi_export.building.native.compiler import PLATFORMS, host_platform

    where = platform or host_platform()
    root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    library = folder / "binaries" / where / f"{root.get('modelName')}{PLATFORMS[where][0]}"
    return library, root.get("guid", ""), (folder / "resources").as_uri()


def run(
    command: Iterable[Any], *arguments: Any, program: Iterable[str] = (), **options: Any
) -> tuple[list[list[str]], str]:
    """Run a program in the host; return status and values of each line, and the messages of the logger."""
    process = subprocess.run(
        [*map(str, command), *map(str, arguments)],
        input="".join(f"{line}\n" for line in program),
        capture_output=True,
        text=True,
        errors="replace",
        timeout=600,
        check=False,
        **options,
    )
    assert process.returncode == 0, f"ended with {process.returncode}: {process.stderr[-3000:]}"
    return [line.split() for line in process.stdout.splitlines()], process.stderr
