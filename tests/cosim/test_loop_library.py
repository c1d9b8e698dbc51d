"""Source of the compiled loop, and the plain loop if none is available."""

import tomllib

import numpy as np
import pytest

from amb_cosim.cosim.building import loop_library
from amb_cosim.cosim.master import compiled
from amb_cosim.cosim.run import simulator
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import make_scenario
from amb_cosim.scenario.simulation import execute
from fmi_export.building.native.compiler import PLATFORMS

SHORT = 'system = "passive"\nOmega = "10 Hz"\nend_time = "20 ms"\nsettle_cycles = 0.5\n'


@pytest.fixture
def load_anew(tmp_path, monkeypatch):
    """`load_library` as a new process has it, with an empty cache and nothing shipped."""
    monkeypatch.setattr(loop_library, "SHIPPED", tmp_path / "nothing")
    monkeypatch.setattr(loop_library, "user_cache", lambda: tmp_path)
    return loop_library.load_library.__wrapped__


def test_the_loop_is_compiled_once(load_anew, tmp_path, monkeypatch):
    pytest.importorskip("ziglang")
    assert load_anew() is not None
    assert [path.name for path in tmp_path.rglob("*.so")] == [loop_library.loop_place("linux64").name]
    monkeypatch.setattr(loop_library, "compile_loop", lambda _: pytest.fail("compiled again"))
    assert load_anew() is not None


def test_a_shipped_loop_is_not_compiled(load_anew, tmp_path, monkeypatch):
    pytest.importorskip("ziglang")
    place = tmp_path / "shipped" / loop_library.loop_place(loop_library.host_platform())
    place.parent.mkdir(parents=True)
    place.write_bytes(loop_library.compile_loop(loop_library.host_platform()))
    monkeypatch.setattr(loop_library, "SHIPPED", tmp_path / "shipped")
    monkeypatch.setattr(loop_library, "compile_loop", lambda _: pytest.fail("compiled"))
    assert load_anew() is not None


@pytest.mark.parametrize("error", [ValueError("no compiler"), PermissionError("no cache")])
def test_without_compiler_or_cache_no_compiled_loop_is_loaded(load_anew, monkeypatch, error):
    def fail(_):
        raise error

    monkeypatch.setattr(loop_library, "compile_loop", fail)
    assert load_anew() is None


def test_plain_loop_replaces_a_missing_compiled_loop_with_equal_results(monkeypatch):
    prepared = prepare_run(make_scenario(tomllib.loads(SHORT), "short"))
    expected = execute(prepared)
    monkeypatch.setattr(simulator, "load_loop", lambda: None)
    monkeypatch.setattr(compiled, "run", lambda *_, **__: pytest.fail("not the plain loop"))
    result = execute(prepared)
    for name in expected.signals.variables:
        np.testing.assert_array_equal(result.signals[name].values, expected.signals[name].values)


@pytest.mark.slow
@pytest.mark.parametrize("platform", PLATFORMS)
def test_the_loop_compiles_for_every_platform(platform):
    pytest.importorskip("ziglang")
    assert len(loop_library.compile_loop(platform)) > 1000
