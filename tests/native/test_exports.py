"""The binaries of every platform: their exports and imports, and that they contain no path of the build machine."""

import re
import zipfile
from pathlib import Path

import pytest
from binaries import read
from standard import STANDARD, STANDARD3

from fmi_export.building.native.compiler import PLATFORMS, host_platform

PROCESSORS = {
    "linux64": ["X86_64"],
    "win64": ["X86_64"],
    "darwin64": ["X86_64", "ARM64"],
    "aarch64-linux": ["ARM64"],
    "aarch64-darwin": ["ARM64"],
}
LIBRARIES = {
    "linux": r"lib[cm]\.so\.6|libdl\.so\.2|ld-linux-aarch64\.so\.1",
    "darwin": r"/usr/lib/libSystem\.B\.dylib",
    "win64": r"KERNEL32\.dll|ntdll\.dll|api-ms-win-crt-\w+-l1-1-0\.dll",
}


# zig's linker adds these to every macOS library. Names are looked up by library there, so they are in nobody's way.
ADDED = {"darwin": {"__dso_handle", "_mh_dylib_header"}}


def check(path, platform):
    with zipfile.ZipFile(path) as archive:
        (name,) = [n for n in archive.namelist() if n.startswith(f"binaries/{platform}/")]
        content = archive.read(name)
    result = read(content)
    assert [binary.processor for binary in result] == PROCESSORS[platform]
    kind = next(kind for kind in LIBRARIES if kind in platform)
    for binary in result:
        assert binary.exports == STANDARD | STANDARD3 | ADDED.get(kind, set())
        assert binary.libraries
        assert all(re.fullmatch(LIBRARIES[kind], name) for name in binary.libraries - {Path(name).name}), (
            binary.libraries
        )
        assert not [name for name in binary.imports if re.match(r"_?Py|NRT_|numba", name)]
        if kind == "linux":
            versions = [tuple(map(int, version.removeprefix("GLIBC_").split("."))) for version in binary.versions]
            assert max(versions) <= (2, 17)
    for trace in (
        b"site-packages",
        b"_ZN",
        b"NumbaEnv",
        b"libpython",
        str(Path.home()).encode() + b"/",
        b"/tmp/",
        b".pdb",
    ):
        assert trace not in content, trace


@pytest.mark.skipif(host_platform() != "linux64", reason="built by default on Linux")
def test_the_linux_library_exports_only_fmi_functions(native, lag):
    check(native(lag), "linux64")


@pytest.mark.slow
@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_library_of_every_platform_exports_only_fmi_functions(native, plant, plant_constants, platform):
    check(native(plant, plant_constants, ["all"]), platform)
