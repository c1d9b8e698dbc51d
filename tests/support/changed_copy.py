"""Packages changed in a copy, and processes that import the copy, without compiled kernels."""

import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]


def change(folder: Path, package: Path, changes: Mapping[str, tuple[tuple[str, str], ...]]) -> None:
    """Copy a package into a folder, and replace texts of its files, each of which must occur once."""
    copy = folder / package.name
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    for name, texts in changes.items():
        file = copy / name
        content = file.read_text(encoding="utf-8")
        for before, after in texts:
            assert content.count(before) == 1, f"{name} has {content.count(before)} times {before!r}"
            content = content.replace(before, after)
        file.write_text(content, encoding="utf-8")


def importing(folder: Path, run_python: Callable[..., Any]) -> Callable[..., Any]:
    """Return `run_python` for processes that import the packages in a folder."""

    def run(function: Callable[..., Any], **arguments: Any) -> Any:
        with pytest.MonkeyPatch.context() as patched:
            paths = [str(folder), str(ROOT / "tests" / "support"), os.environ.get("PYTHONPATH", "")]
            patched.setenv("PYTHONPATH", os.pathsep.join(paths))
            patched.setenv("NUMBA_DISABLE_JIT", "1")
            return run_python(function, **arguments)

    return run
