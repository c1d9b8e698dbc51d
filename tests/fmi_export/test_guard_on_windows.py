"""The guard as a library for Windows, under wine, where there is no Python: what it refuses before it needs one."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fmi_export.building import python_fmu

NATIVE = Path(python_fmu.__file__).parent / "native"
SUPPORT = Path(__file__).parents[1] / "native" / "support"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="wine runs on Linux"),
    pytest.mark.skipif(not (shutil.which("wine64") or shutil.which("wine")), reason="needs wine"),
]


@pytest.fixture(scope="module")
def fmu(lag, tmp_path_factory):
    """Folder of an FMU for Windows."""
    pytest.importorskip("ziglang")
    folder = tmp_path_factory.mktemp("windows")
    with zipfile.ZipFile(python_fmu.build_python_fmu(lag, np.zeros(1), folder, ["win64"])) as archive:
        archive.extractall(folder)
    return folder


@pytest.fixture(scope="module")
def refusal(fmu, tmp_path_factory):
    """`refusal(location)`: what the guard says of resources there."""
    folder = tmp_path_factory.mktemp("host")
    headers, target = f"-I{NATIVE / 'fmi_headers'}", "x86_64-windows-gnu"
    command = [sys.executable, "-m", "ziglang", "cc", "-target", target, "-std=gnu11", "-Wno-everything", headers]
    subprocess.run([*command, str(SUPPORT / "host.c"), "-o", str(folder / "host.exe")], check=True)
    wine = shutil.which("wine64") or shutil.which("wine")
    library = fmu / "binaries" / "win64" / "probe_lag.dll"
    guid = ElementTree.parse(fmu / "modelDescription.xml").getroot().get("guid")

    def run(location: str) -> str:
        process = subprocess.run(
            [str(wine), str(folder / "host.exe"), str(library), str(guid), location],
            input="new 0\n",
            env={**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"},
            capture_output=True,
            text=True,
            timeout=600,
            check=False,
        )
        assert (process.returncode, process.stdout.split()) == (0, ["3"]), process.stderr
        return process.stderr

    return run


def test_without_python_there_is_no_instance_but_a_reason(fmu, refusal):
    encoded = (fmu / "resources").as_uri().removeprefix("file://")
    for location in (f"file:///Z:{encoded}", f"file:/Z:{encoded}/", f"Z:{fmu / 'resources'}".replace("/", "\\")):
        text = refusal(location)
        assert "this FMU needs Python, but the process has none" in text
        assert "in PATH" in text


def test_a_folder_without_resources_is_refused_before_python_is_needed(fmu, refusal):
    assert "cannot read Z:\\nowhere/model.bin: No such file or directory" in refusal("Z:\\nowhere")
    assert "the resource location https://server/share is not on this machine" in refusal("https://server/share")
    encoded = shutil.copytree(fmu / "resources", fmu / "a%20b")
    assert "PythonFMU reads no folder with %20 in its path" in refusal(f"Z:{encoded}")
