"""Building blocks of the orchestrator's tests."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture(scope="session", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory):
    """FMUs are built into a cache of this test session, not the user's."""
    patch = pytest.MonkeyPatch()
    folder = tmp_path_factory.mktemp("cache")
    patch.setenv("XDG_CACHE_HOME", str(folder))
    patch.setattr("orchestrator.build.platformdirs.user_cache_path", lambda *_, **__: folder / "amb-cosim")
    yield folder
    patch.undo()


@pytest.fixture
def cosim(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Runs `amb-cosim` in a process of its own, in an empty folder: FMUs with Python inside stay apart."""

    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        code = "from orchestrator.cli import main; main(prog_name='amb-cosim')"
        return subprocess.run(
            [sys.executable, "-c", code, *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=300
        )

    return call
