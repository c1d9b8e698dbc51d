"""The guard as a library for Windows, under wine without Python: errors before and at the start of Python."""

import os
import shutil
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from hosts import HEADERS, SUPPORT, binary_of, run

from fmi_export.building import python_fmu

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
    command = [sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu", "-std=gnu11", "-Wno-everything"]
    subprocess.run([*command, f"-I{HEADERS}", SUPPORT / "host.c", "-o", folder / "host.exe"], check=True)
    wine = [shutil.which("wine64") or shutil.which("wine"), folder / "host.exe"]
    library, guid, _ = binary_of(fmu, "win64")
    library = shutil.copytree(library.parent, folder / "alone") / library.name  # away from the resources
    environment = {**os.environ, "WINEPREFIX": str(folder / "wine"), "WINEDEBUG": "-all"}

    def say(location: str) -> str:
        answers, log = run(wine, library, guid, location, program=["new 0"], env=environment)
        assert answers == [["3"]], log
        return log

    return say


def test_without_python_no_instance_is_made_and_the_reason_is_logged(fmu, refusal):
    encoded = (fmu / "resources").as_uri().removeprefix("file://")
    for location in (f"file:///Z:{encoded}", f"file:/Z:{encoded}/", f"Z:{fmu / 'resources'}".replace("/", "\\")):
        text = refusal(location)
        assert "this FMU needs Python, but the process has none" in text
        assert "in PATH" in text


def test_a_folder_without_resources_is_refused_before_python_is_needed(fmu, refusal):
    assert "cannot read Z:\\nowhere/model.bin: No such file or directory" in refusal("Z:\\nowhere")
    assert "the resource location https://server/share is not on this machine" in refusal("https://server/share")
    encoded = shutil.copytree(fmu / "resources", fmu / "a%20b")
    assert "PythonFMU cannot read a folder with %20 in its path" in refusal(f"Z:{encoded}")
