"""Platforms, the required compiler, and macOS's universal libraries."""

import importlib.metadata
import struct
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.version import Version

from fmi_export.building.native import compiler
from fmi_export.building.native.compiler import PLATFORMS, TARGETS, check_platforms
from fmi_export.building.native.universal import universal
from tests.support.messages import raises_naming

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def _asked_anew():
    compiler.check_compiler.cache_clear()
    yield
    compiler.check_compiler.cache_clear()


@pytest.mark.parametrize(
    ("call", "facts"),
    [
        (lambda: check_platforms(["linux64", "win32"]), ("win32", "linux64, win64, darwin64, aarch64-linux")),
        (lambda: check_platforms([]), ("linux64, win64",)),
        (lambda: universal([b"\x7fELF" + bytes(20)]), ("64-bit Mach-O",)),
    ],
)
def test_an_unknown_platform_and_a_library_of_another_are_refused(call, facts):
    with raises_naming(ValueError, *facts):
        call()


def test_all_means_every_platform_and_duplicates_count_once():
    assert check_platforms(["all", "win64"]) == list(PLATFORMS)
    assert check_platforms(["win64", "linux64", "win64"]) == ["linux64", "win64"]
    assert check_platforms(["wasm32", "all"]) == list(TARGETS)


def test_error_of_a_missing_compiler_names_the_package_to_install(monkeypatch):
    monkeypatch.setattr("fmi_export.building.extras.find_spec", lambda name: None)
    with raises_naming(ValueError, "ziglang", "pip install", "[native]"):
        compiler.check_compiler()


def test_an_llvm_version_that_differs_from_numba_is_named(monkeypatch):
    pytest.importorskip("llvmlite")
    monkeypatch.setattr("fmi_export.building.extras.find_spec", lambda name: object())
    monkeypatch.setattr(compiler, "_zig", lambda arguments, folder: "clang version 9.0.1\nTarget: x")
    with pytest.raises(ValueError, match=r"numba .* LLVM \d+, .* ziglang .* LLVM 9\b"):
        compiler.check_compiler()


@pytest.mark.usefixtures("compiler")
def test_newest_allowed_numba_and_zig_share_an_llvm_version():
    """Both have an upper bound, since the LLVM of a newer zig cannot read what an older numba writes."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    texts = [*project["dependencies"], *project["optional-dependencies"]["native"]]
    allowed = {requirement.name: requirement.specifier for requirement in map(Requirement, texts)}
    for name in ("numba", "ziglang"):
        installed = Version(importlib.metadata.version(name))
        assert installed in allowed[name]
        assert f"{installed.major}.{installed.minor + 1}.0" not in allowed[name]
    assert compiler.check_compiler() == importlib.metadata.version("ziglang")


@pytest.mark.usefixtures("compiler")
def test_messages_of_the_compiler_reach_the_user():
    with raises_naming(ValueError, "zig cc", "no_such_function"):
        compiler.compile_library("x", {"x.c": "int f(void) { return no_such_function(); }"}, "linux64")


def test_slices_of_a_universal_library_are_aligned_to_pages():
    slices = [
        struct.pack("<III", 0xFEEDFACF, 0x01000000 + kind, 3) + bytes(size) for kind, size in ((7, 5), (12, 40000))
    ]
    whole = universal(slices)
    magic, count = struct.unpack_from(">II", whole)
    assert (magic, count) == (0xCAFEBABE, 2)
    for i, content in enumerate(slices):
        processor, variant, offset, size, alignment = struct.unpack_from(">IIIII", whole, 8 + 20 * i)
        assert (processor, variant) == struct.unpack_from("<II", content, 4)
        assert offset % (1 << alignment) == 0
        assert whole[offset : offset + size] == content
