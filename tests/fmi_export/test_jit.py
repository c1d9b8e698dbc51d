"""The kernels' on-disk cache."""

import subprocess
import sys
from pathlib import Path

import pytest

CALLER = """
from fmi_export.jit import kernel
from {package}.callee import two

@kernel
def doubled(x):
    return two() * x
"""
CALLEE = """
from fmi_export.jit import kernel

@kernel
def two():
    return {}
"""


def host(folder: str) -> list:
    import sys

    sys.dont_write_bytecode = True  # Python's own cache notices no change within a second
    sys.path.insert(0, folder)
    from cached.caller import doubled

    return [doubled(3.0), sum(doubled.stats.cache_hits.values())]


def write(folder: Path, package: str, value: float) -> Path:
    """Write the changed files of a package, in which one kernel calls another; return its folder."""
    (folder / package).mkdir(exist_ok=True)
    texts = {"__init__.py": "", "caller.py": CALLER.format(package=package), "callee.py": CALLEE.format(value)}
    for name, text in texts.items():
        file = folder / package / name
        if not file.exists() or file.read_text() != text:
            file.write_text(text)
    return folder / package


@pytest.mark.slow
@pytest.mark.parametrize("package", ["cached", "beneath"])
def test_kernel_is_compiled_again_when_a_kernel_that_it_calls_changed(run_python, tmp_path, package):
    """Of its package, or of another one that its package names."""
    results = []
    for value in (2.0, 2.0, 5.0):
        write(tmp_path, package, value)
        if package == "beneath":
            (tmp_path / "cached").mkdir(exist_ok=True)
            (tmp_path / "cached" / "__init__.py").write_text('PACKAGES = ("cached", "beneath")')
            (tmp_path / "cached" / "caller.py").write_text(CALLER.format(package="beneath"))
        results.append(run_python(host, folder=tmp_path))
    (first, _), (again, hits), (changed, _) = results
    assert (first, again, changed) == (6.0, 6.0, 15.0)
    assert hits == 1 or package == "beneath", "unchanged code comes from the cache"


def test_a_kernel_without_numba_is_the_function_itself(run_python):
    def without_numba() -> list:
        from hide import hide

        hide("numba")
        from fmi_export.jit import COMPILED, kernel

        def function(x):
            return 2 * x

        return [COMPILED, kernel(function) is function]

    assert run_python(without_numba) == [False, True]


def test_a_kernel_divides_as_ieee_arithmetic_does():
    from fmi_export.jit import kernel

    @kernel
    def quotient(a, b):
        return a / b

    assert quotient(1.0, 0.0) == pytest.approx(float("inf"))


def test_kernels_below_an_inlined_kernel_are_not_inlined():
    from fmi_export.jit import inlined_kernel, kernel

    @kernel
    def below(x):
        return 2.0 * x

    @inlined_kernel
    def inlined(x):
        return below(x) + 1.0

    @kernel
    def caller(x):
        return inlined(x)

    assert caller(3.0) == 7.0
    attributes = {k: "alwaysinline" in k.inspect_llvm(k.signatures[0]) for k in (below, inlined)}
    assert attributes == {below: False, inlined: True}


SCRIPT = """
from beside import doubled
from fmi_export.jit import kernel
from fmi_export.numba_internals import folder_of_cache

@kernel
def changed(x):
    return doubled(x) + 1.0

print(changed(2.0), folder_of_cache(changed))
"""
BESIDE = """
from fmi_export.jit import kernel

@kernel
def doubled(x):
    return {factor} * x
"""


def test_a_kernel_of_a_script_is_compiled_in_each_run(tmp_path):
    """Nobody knows which code beside the script it may call, and a home folder is too much to read."""
    (tmp_path / "script.py").write_text(SCRIPT)
    for factor, result in ((2.0, 5.0), (3.0, 7.0)):
        (tmp_path / "beside.py").write_text(BESIDE.format(factor=factor))
        done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=True)
        assert done.stdout.split() == [str(result), "None"]


def test_literal_arguments_share_one_compiled_kernel():
    from fmi_export.jit import kernel

    @kernel
    def scaled(x, factor, is_negative):
        return -factor * x if is_negative else factor * x

    @kernel
    def caller(x):
        return scaled(x, 2, False) + 10.0 * scaled(x, 3, True)

    assert caller(1.0) == -28.0
    assert len(scaled.signatures) == 1


def test_a_kernel_that_allocates_is_not_compiled():
    import numba
    import numpy as np

    from fmi_export.jit import kernel

    @kernel
    def total(n):
        return np.ones(n).sum()

    with pytest.raises(numba.core.errors.TypingError):
        total(3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["nbi", "nbc"])
def test_a_damaged_cache_of_a_kernel_is_rebuilt(run_python, tmp_path, monkeypatch, kind):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "machine_code"))
    write(tmp_path, "cached", 2.0)
    run_python(host, folder=tmp_path)
    files = list(tmp_path.rglob(f"*.{kind}"))
    assert files
    for file in files:
        file.write_bytes(file.read_bytes()[:20])
    assert [run_python(host, folder=tmp_path) for _ in range(2)] == [[6.0, 0], [6.0, 1]]


def test_a_kernel_is_compiled_where_no_cache_can_be_written(run_python, tmp_path):
    def doubled(folder: str) -> float:
        import os
        import sys

        os.environ.update(HOME="/dev/null", XDG_CACHE_HOME="/dev/null", IPYTHONDIR="/dev/null")
        sys.path.insert(0, folder)
        from uncached.caller import doubled

        return doubled(3.0)

    (write(tmp_path, "uncached", 2.0) / "__pycache__").touch()  # a file where the folder would be
    assert run_python(doubled, folder=tmp_path) == 6.0
