"""The archive of a native FMU: description, binaries, bytes."""

import importlib.metadata
import shutil
import subprocess
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.building.identity import guid_of
from fmi_export.building.native.compiler import PLATFORMS, host_platform
from fmi_export.building.native.package import native_guid

OWN = {"guid", "generationTool"}


def xml_of(path):
    with zipfile.ZipFile(path) as archive:
        return ElementTree.fromstring(archive.read("modelDescription.xml"))


@pytest.fixture(scope="module", params=["lag", pytest.param("plant", marks=pytest.mark.slow)])
def case(request):
    model = request.getfixturevalue(request.param)
    constants = np.zeros(1) if request.param == "lag" else request.getfixturevalue("plant_constants")
    return model, constants


def test_description_equals_that_of_the_python_flavour(native, build_fmu, case):
    ours, theirs = xml_of(native(*case)), xml_of(build_fmu(*case))
    assert ours.get("guid") != theirs.get("guid")
    assert ours.find("CoSimulation").get("needsExecutionTool") == "false"
    for root in (ours, theirs):
        for attribute in OWN:
            root.set(attribute, "")
        root.find("CoSimulation").set("needsExecutionTool", "")
        ElementTree.indent(root)
    assert ElementTree.tostring(ours) == ElementTree.tostring(theirs)


def test_the_tool_names_all_versions_that_made_the_binary(native, lag):
    tool = xml_of(native(lag)).get("generationTool")
    for name in ("amb-cosim", "numba", "ziglang"):
        assert f"{name} {importlib.metadata.version(name)}" in tool


def test_the_guid_changes_with_constants_flavour_and_version(lag):
    guids = {native_guid(lag, np.zeros(1)), native_guid(lag, np.ones(1)), guid_of(lag, np.zeros(1))}
    assert len(guids | {native_guid(lag, np.zeros(1), 3)}) == 4


def test_the_archive_has_engine_data_documentation_and_an_experiment(native, lag):
    library = f"binaries/{host_platform()}/probe_lag{PLATFORMS[host_platform()][0]}"
    experiment = ("fmi-ls-manifest.xml", "references.csv", "smoke_test.exp")
    with zipfile.ZipFile(native(lag)) as archive:
        assert archive.namelist() == [
            library,
            "documentation/fmi-ls-ref.txt",
            "documentation/index.html",
            "documentation/licenses/license.txt",
            *(f"extra/org.fmi-standard.fmi-ls-ref/{name}" for name in experiment),
            "modelDescription.xml",
            "resources/layout.json",
            "resources/model.bin",
        ]


def test_python_fmu_is_independent_of_the_native_flavour(build_fmu, lag, tmp_path):
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        assert not [name for name in archive.namelist() if "building" in name or "native" in name]
    package = tmp_path / "fmi_export"
    shutil.copytree(Path(bootstrap.__file__).parent, package, ignore=shutil.ignore_patterns("__pycache__"))
    before = bootstrap.digest(package)
    (package / "building" / "native" / "another.py").touch()
    assert bootstrap.digest(package) == before
    (package / "another.py").touch()
    assert bootstrap.digest(package) != before


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_vdmcheck_finds_no_error(native, lag, fmi):
    """VDMCheck of the INTO-CPS association checks rules of FMI that no schema has, written in VDM."""
    checker = shutil.which(f"VDMCheck{fmi}.sh")
    if checker is None:
        pytest.skip("VDMCheck is not installed")
    command = [checker, str(native(lag, None, None, fmi))]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.stdout.splitlines()[-1:] == ["No errors found."], done.stdout
