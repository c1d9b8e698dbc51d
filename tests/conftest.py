"""Fixtures of all tests: subprocesses, and builds made once per test run and shared by the workers of pytest-xdist."""

import gc
import hashlib
import inspect
import json
import os
import random
import signal
import subprocess
import sys
import textwrap
import zipfile
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

# Before numpy is loaded, here and in workers and subprocesses: the matrices are small, and threads would only wait.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
if "AMB_COSIM_TEST_CACHE" in os.environ:  # before numba is loaded; a fresh installation then compiles nothing again
    os.environ.setdefault("NUMBA_CACHE_DIR", str(Path(os.environ["AMB_COSIM_TEST_CACHE"], "numba")))

import hypothesis
import platformdirs
import pytest
import pythonfmu.builder  # noqa: F401 - before an FMU that runs in this process brings its own, which cannot build FMUs
from filelock import FileLock

from amb_files.atomic import create_atomically

# The search for counterexamples is random at a developer's desk and the same every time where a build depends on it.
# No deadlines: a first example may compile a kernel.
hypothesis.settings.register_profile("patient", deadline=None)
hypothesis.settings.register_profile("repeatable", deadline=None, derandomize=True)
hypothesis.settings.load_profile("patient")
if os.environ.get("CI"):
    hypothesis.settings.load_profile("repeatable")

HERE = Path(__file__).parent
# Modules that subprocesses can import too: probes and hosts, and calls of a library as in C.
SUPPORT, NATIVE_SUPPORT = HERE / "fmi_export" / "support", HERE / "native" / "support"
sys.path[:0] = [str(HERE / "support"), str(SUPPORT), str(NATIVE_SUPPORT)]


@pytest.fixture
def is_long(request: pytest.FixtureRequest) -> bool:
    """Whether campaigns are as long as they get: the option `--long`."""
    return bool(request.config.getoption("--long"))


@pytest.fixture
def first_seed(is_long: bool) -> int:
    """The same seed in every short campaign, another in each long one; messages name it."""
    return random.SystemRandom().randrange(10**6) if is_long else 2006


@pytest.fixture(autouse=True)
def quiet(monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands that compute print no line after two seconds, which they take only on a busy computer."""
    from amb_cosim.presentation import progress

    monkeypatch.setattr(progress, "PATIENCE", progress.INTERVAL)


@pytest.fixture
def few_speeds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Studies begin with few speeds, for tests in which their number does not matter."""
    from amb_analysis.studies import closed_loop_poles, contact_traps, unbalance_over_speed

    monkeypatch.setattr(closed_loop_poles, "POINTS", 7)
    monkeypatch.setattr(contact_traps, "SPEEDS", 20)
    monkeypatch.setattr(unbalance_over_speed, "LEVITATED", 9)
    monkeypatch.setattr(unbalance_over_speed, "POINTS", 65)


@pytest.fixture(scope="session", autouse=True)
def signals() -> Iterator[None]:
    """SIGINT, SIGTERM and SIGHUP as in a terminal, for subprocesses too: a job in the background ignores some."""
    local = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL, signal.SIGHUP: signal.SIG_DFL}
    before = {number: signal.signal(number, handler) for number, handler in local.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def receptance() -> Any:
    """A random receptance, shape (8, 4)."""
    from rig import random_receptance

    return random_receptance()


@pytest.fixture(scope="session")
def lag() -> Any:
    """A first-order lag with state, all variable types, ranges and faults (`fmi_export/support/probe_lag`)."""
    from probe_lag.lag import MODEL

    return MODEL


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of this test run that all workers share."""
    local = tmp_path_factory.getbasetemp()
    return local.parent if "PYTEST_XDIST_WORKER" in os.environ else local


@pytest.fixture(scope="session")
def create_once(shared_folder: Path) -> Callable[..., Path]:
    """`create_once(name, fill)`: folder of that name, filled by the first worker that requests it; the others wait."""

    def create(name: str, fill: Callable[[Path], object]) -> Path:
        folder = shared_folder / "once" / name
        folder.parent.mkdir(exist_ok=True)
        with FileLock(f"{folder}.lock"):
            create_atomically(folder, fill)
        return folder

    return create


@pytest.fixture(scope="session")
def fmu_from_c(create_once: Callable[..., Path]) -> Callable[..., Path]:
    """`fmu_from_c(source, description, version=2)`: path of the FMU of a file of C, compiled once per test run.

    Those of one file with other descriptions have a `name` each.
    """
    from c_fmus import compile_fmu

    def compile_once(source: Path, description: str, version: int = 2, name: str = "") -> Path:
        name = f"{name or source.stem}-fmi{version}"
        folder = create_once(name, lambda folder: compile_fmu(folder, source, description, version))
        return folder / f"{source.stem.capitalize()}.fmu"

    return compile_once


@pytest.fixture
def hostile(fmu_from_c: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> Any:
    """`Hostility`: what a hostile FMU will do, and the processes that it has started."""
    from hostile import Hostility

    return Hostility(fmu_from_c, monkeypatch)


@pytest.fixture(scope="session")
def unpack(create_once: Callable[..., Path]) -> Callable[[Path], Path]:
    """`unpack(fmu)`: the folder of an extracted FMU, extracted once per test run."""
    return lambda fmu: create_once(f"{fmu.parent.name}-extracted", zipfile.ZipFile(fmu).extractall)


@pytest.fixture(scope="session", autouse=True)
def cache(shared_folder: Path) -> Iterator[Path]:
    """Folder of built FMUs and engines, not the user's; the C compiler's own cache stays where it is.

    It belongs to this test run, or is the folder that AMB_COSIM_TEST_CACHE names: what is in it is named after the code
    that it was made from, so that later runs need not build it again.
    """
    patch = pytest.MonkeyPatch()
    folder = Path(os.environ.get("AMB_COSIM_TEST_CACHE") or shared_folder / "cache")
    folder.mkdir(parents=True, exist_ok=True)
    patch.setenv("ZIG_GLOBAL_CACHE_DIR", os.environ.get("ZIG_GLOBAL_CACHE_DIR", platformdirs.user_cache_dir("zig")))
    patch.setenv("XDG_CACHE_HOME", str(folder))
    patch.setattr("platformdirs.user_cache_path", lambda name, *_, **__: folder / name)
    yield folder
    patch.undo()


@pytest.fixture(scope="session")
def run_python(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Any]:
    """`run_python(what, timeout=180, cwd=None, **arguments)` in a separate Python process.

    `what` is a function, which must import what it needs in its body and is called with `arguments`, or the text
    of a program. The function's return value, or what the program assigns to `result`, comes back through JSON
    (floats to the last bit).
    A process that fails, crashes on exit, or takes longer than `timeout` seconds fails the test with its output.
    """

    def run(what: Callable[..., Any] | str, timeout: float = 180.0, cwd: Path | None = None, **arguments: Any) -> Any:
        folder = tmp_path_factory.mktemp("process")
        answer = folder / "answer.json"
        if callable(what):
            body = "from __future__ import annotations\n" + textwrap.dedent(inspect.getsource(what))
            values = folder / "arguments.json"
            values.write_text(json.dumps(arguments, default=str), encoding="utf-8")
            call = f"result = {what.__name__}(**json.loads(pathlib.Path({str(values)!r}).read_text()))"
        else:
            body, call = what, "result = globals().get('result')"
        script = folder / "script.py"
        script.write_text(
            f"{body}\nimport json, pathlib\n{call}\npathlib.Path({str(answer)!r}).write_text(json.dumps(result))\n",
            encoding="utf-8",
        )
        paths = [str(SUPPORT), str(NATIVE_SUPPORT), str(HERE.parent)]  # the last for benchmarks and tools
        paths += filter(None, [os.environ.get("PYTHONPATH")])
        process = subprocess.run(
            [sys.executable, str(script)],
            cwd=cwd or folder,
            # what a host extracts and leaves behind goes with pytest's folders
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths), "TMPDIR": str(folder)},
            capture_output=True,
            text=True,
            timeout=timeout,
            check=False,
        )
        output = f"{process.stdout[-4000:]}\n{process.stderr[-4000:]}"
        assert process.returncode == 0, f"the process ended with {process.returncode}:\n{output}"
        return json.loads(answer.read_text(encoding="utf-8"))

    return run


@pytest.fixture(scope="session")
def run_once(run_python: Callable[..., Any], create_once: Callable[..., Path]) -> Callable[..., Any]:
    """The same as `run_python` with a function, computed once per test run: the same call returns the same result."""

    def run(function: Callable[..., Any], timeout: float = 180.0, **arguments: Any) -> Any:
        facts = inspect.getsource(function) + json.dumps(arguments, sort_keys=True, default=str)
        name = f"{function.__name__}-{hashlib.sha256(facts.encode()).hexdigest()[:32]}"

        def fill(folder: Path) -> None:
            result = run_python(function, timeout, **arguments)
            (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")

        return json.loads((create_once(name, fill) / "result.json").read_text(encoding="utf-8"))

    return run


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Callable[[str], Path]]:
    """`small_disk(size)`: folder of a file system of that size."""
    folder, mounted = tmp_path / "disk", []

    def mount(size: str) -> Path:
        folder.mkdir()
        command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "none", str(folder)]
        if sys.platform != "linux" or subprocess.run(command, capture_output=True, check=False).returncode:
            pytest.skip("this user cannot mount a small file system")
        mounted.append(folder)
        return folder

    yield mount
    for place in mounted:
        subprocess.run(["umount", "-l", place], check=True)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate", action="store_true", help="write the regression data in tests/regression anew")
    parser.addoption("--long", action="store_true", help="make the campaigns in tests/robustness as long as they get")
    parser.addoption("--hosts", type=Path, metavar="FILE", help="write down there which hosts ran which FMUs")
    parser.addoption("--absences", type=Path, metavar="FILE", help="fail if a test is skipped for a reason not in it")


def pytest_configure(config: pytest.Config) -> None:
    import waiting_for_kernels

    config.pluginmanager.register(waiting_for_kernels)
    if (file := config.getoption("--absences")) and not hasattr(config, "workerinput"):
        from absences import Absences

        config.pluginmanager.register(Absences(file))
    if file := config.getoption("--hosts"):
        from tools.compatibility.record import HostRecord

        config.pluginmanager.register(HostRecord(file))


@pytest.fixture
def regression(request: pytest.FixtureRequest, shared_folder: Path) -> Callable[..., None]:
    """`regression(name, found, rel=None, abs=None)`: compare a number, list or dict with the regression data.

    Regression data are numbers that this project itself computed, in `tests/regression/<test module>.json` by test and
    name. With the option `--regenerate` what is found is written there instead.
    """
    file = HERE / "regression" / f"{request.path.stem.removeprefix('test_')}.json"

    def check(name: str, found: Any, rel: float | None = None, abs: float | None = None) -> None:
        if request.config.getoption("--regenerate"):
            with FileLock(shared_folder / f"{file.name}.lock"):
                data = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
                data.setdefault(request.node.name, {})[name] = rounded(found)
                file.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n", encoding="utf-8")
            return
        expected = json.loads(file.read_text(encoding="utf-8"))[request.node.name][name]
        assert found == pytest.approx(expected, rel=rel, abs=abs), name

    return check


def rounded(value: Any) -> Any:
    """The same number, list or dict with six significant digits."""
    if isinstance(value, dict):
        return {key: rounded(entry) for key, entry in value.items()}
    return [rounded(entry) for entry in value] if isinstance(value, list | tuple) else float(f"{value:.6g}")


@pytest.fixture(scope="session")
def build_fmu(create_once: Callable[..., Path]) -> Callable[..., Path]:
    """`build_fmu(model, constants=None)`: path of the FMU, built once per test run."""
    import numpy as np

    from fmi_export.building.python_fmu import build_python_fmu, python_guid
    from fmi_export.model import Model

    def build(model: Model, constants: Any = None) -> Path:
        numbers = np.zeros(1) if constants is None else constants
        home = create_once(
            f"{model.name}-{python_guid(model, numbers).strip('{}')}",
            lambda folder: build_python_fmu(model, numbers, folder),
        )
        return home / f"{model.name}.fmu"

    return build


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect the tests without searches for reference cycles, which took a third of the time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()  # what is collected stays until the end, so no search need visit it
