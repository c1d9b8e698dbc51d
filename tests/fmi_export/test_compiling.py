"""Of several processes that need the same code, one compiles it."""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from click.testing import CliRunner
from waiting import LONGEST

from amb_cosim.commands.cli import main
from fmi_export.building.native import engines
from fmi_export.building.native.compiler import PLATFORMS, host_platform
from fmi_export.building.native.engines import Engine, find_or_compile
from tests.support.messages import assert_names

LAW = Path(__file__).parents[2] / "examples" / "controllers" / "cross_feedback.toml"
KERNELS = """
from fmi_export.jit import kernel

@kernel
def two():
    return 2.0

@kernel
def doubled(x):
    return two() * x
"""
CALLER = """
import pathlib, sys, time
sys.path.insert(0, {folder!r})
from shared.kernels import doubled
pathlib.Path({folder!r}, "ready-{k}").touch()
while len(list(pathlib.Path({folder!r}).glob("ready-*"))) < {n}:
    time.sleep(0.01)
print(doubled(3.0), sum(doubled.stats.cache_hits.values()))
"""
HOLDER = """
import pathlib, time
from fmi_export import compiling
compiling.SILENT_WAIT = 0.1
with compiling.compiling(pathlib.Path({place!r}), "the thing"):
    print("in", flush=True)
    time.sleep({seconds})
"""


def started(program: str) -> subprocess.Popen[str]:
    return subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    """Machine code of kernels that no other test has compiled."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "machine_code"))


def test_kernels_are_compiled_by_one_process_of_those_that_begin_together(tmp_path):
    (tmp_path / "shared").mkdir()
    (tmp_path / "shared" / "__init__.py").touch()
    (tmp_path / "shared" / "kernels.py").write_text(KERNELS)
    processes = [started(CALLER.format(folder=str(tmp_path), k=k, n=3)) for k in range(3)]
    answers = sorted(process.communicate(timeout=LONGEST)[0].strip() for process in processes)
    assert answers == ["6.0 0", "6.0 1", "6.0 1"], "one compiles, the others read what it has kept"
    assert not list(tmp_path.rglob("*.lock"))


def test_a_process_that_is_killed_frees_the_one_that_waits(tmp_path):
    place = str(tmp_path / "thing")
    first = started(HOLDER.format(place=place, seconds=1000))
    assert first.stdout is not None
    assert first.stdout.readline() == "in\n"
    second = started(HOLDER.format(place=place, seconds=0))
    assert second.stderr is not None
    assert_names(second.stderr.readline(), "waiting", "make the thing")
    first.kill()
    assert second.communicate(timeout=LONGEST)[0] == "in\n"
    first.communicate()


def test_an_engine_is_compiled_once_by_those_that_begin_together(tmp_path, monkeypatch):
    monkeypatch.setattr(engines, "_cache", lambda: tmp_path)
    compiled = []

    def compile_slowly() -> Engine:
        compiled.append(1)
        time.sleep(0.3)
        return Engine(b"code", "a compiler")

    with ThreadPoolExecutor(4) as threads:
        found = list(threads.map(lambda _: find_or_compile(Path("linux64", "one"), compile_slowly), range(4)))
    assert found == [Engine(b"code", "a compiler")] * 4
    assert len(compiled) == 1


def test_build_prints_each_model_and_platform_when_it_is_compiled(tmp_path, monkeypatch):
    """The second command finds both engines in the cache."""
    monkeypatch.setattr(engines, "_cache", lambda: tmp_path / "cache")
    monkeypatch.setattr(engines, "_compile", lambda models, platform: Engine(platform.encode(), "a compiler"))
    monkeypatch.setattr(engines, "SHIPPED", tmp_path)
    others = [name for name in PLATFORMS if name != host_platform()][:2]  # an engine of this machine would be loaded
    asked = ["build", "--controller", str(LAW), "--platform", ",".join(others), "-o", str(tmp_path / "fmus")]
    first, second = (CliRunner().invoke(main, asked) for _ in range(2))
    assert (first.exit_code, second.exit_code) == (0, 0), repr(first.exception)
    for line, platform in zip(first.stderr.splitlines(), others, strict=True):
        assert_names(line, "linear_controller", platform)
    assert second.stderr == ""


@pytest.mark.parametrize("error", [PermissionError("a folder of others"), NotImplementedError("no locks here")])
def test_compilation_proceeds_where_no_lock_is_possible(tmp_path, monkeypatch, error):
    from fmi_export import compiling

    def refuse(_):
        raise error

    monkeypatch.setattr("filelock.FileLock", refuse)
    with compiling.compiling(tmp_path / "thing", "the thing"):
        pass
