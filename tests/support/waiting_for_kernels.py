"""Waits for compiled kernels: of each model they are compiled once per test run, before the first test that runs them.

A plugin of pytest, which tests/conftest.py registers.
"""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

import pytest
from filelock import FileLock

HERE = Path(__file__).parent
MODELS = ("rotor_contact", "amb_actuator", "rolac_controller")
ALONE = ("linear_controller",)  # models that no test of the others runs
# Folders of tests of which some run the compiled kernels of all models, in instances of their own process.
RUN_SOME_KERNELS = ("amb_analysis", "amb_live", "amb_sweeps", "benchmarks", "cosim", "orchestrator", "packs")
# Folders of tests that run them in any way.
RUN_ALL_KERNELS = (*RUN_SOME_KERNELS, "levitated_rotor", "native", "referees", "strange_machine", "system")


def folder_of(path: Path) -> str:
    return path.relative_to(HERE.parent).parts[0]


def models_of(path: Path) -> tuple[str, ...]:
    """Return the models whose compiled kernels the tests of a file run."""
    folder = folder_of(path)
    return MODELS if folder in RUN_ALL_KERNELS else tuple(name for name in (*MODELS, *ALONE) if name == folder)


def share_of_kernels(path: Path) -> int:
    """Return how much the tests of a file wait for compiled kernels: 0 not at all, 1 some of them, 2 all."""
    return 0 if not models_of(path) else 1 if folder_of(path) in RUN_SOME_KERNELS else 2


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Let each worker begin with tests that run no kernels, then few: those are compiled meanwhile.

    A worker of pytest-xdist begins with its share of the list, one after the other.
    """
    n = getattr(config, "workerinput", {}).get("workercount", 1)
    kinds = [[item for item in items if share_of_kernels(item.path) == share] for share in range(3)]
    shares = [[of_kind[k * len(of_kind) // n : (k + 1) * len(of_kind) // n] for of_kind in kinds] for k in range(n)]
    items[:] = [item for share in shares for of_kind in share for item in of_kind]


@pytest.fixture(scope="session", autouse=True)
def wait_for_kernels(
    request: pytest.FixtureRequest, cache: Path, shared_folder: Path
) -> Iterator[Callable[[Collection[str]], None]]:
    """`wait_for_kernels(models)` until they are compiled, which the first worker has done for all.

    Those of each model that tests run are compiled into numba's cache on disk, in a process of its own.
    """
    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield lambda models: None
        return
    from fmi_export.model import Instance

    folder = shared_folder / "kernels"
    names = {name for item in request.session.items for name in models_of(item.path)}
    with FileLock(f"{folder}.lock"):
        if not folder.exists():
            folder.mkdir()
            called = called_kernels()
            for name in names:
                threading.Thread(target=compile_kernels, args=(folder, name, called), daemon=True).start()

    def wait(models: Collection[str]) -> None:
        end = time.monotonic() + 600.0
        while not all((folder / name).exists() for name in names.intersection(models)) and time.monotonic() < end:
            time.sleep(0.1)

    initialise = Instance.initialise

    def initialise_compiled(instance: Instance) -> None:
        wait([instance.model.name])
        initialise(instance)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Instance, "initialise", initialise_compiled)
        yield wait


def called_kernels() -> list[str]:
    """Return the kernels that modules outside their packages have loaded, `module.function`: Python calls those."""
    from numba.extending import is_jitted

    kernels = (
        value.py_func
        for name, module in list(sys.modules.items())
        if name.partition(".")[0] not in (*MODELS, *ALONE, "signal_chain", "fmi_export")
        for value in list(getattr(module, "__dict__", {}).values())
        if is_jitted(value)
    )
    return sorted({f"{kernel.__module__}.{kernel.__qualname__}" for kernel in kernels})


def compile_kernels(folder: Path, model: str, called: list[str]) -> None:
    """Compile the kernels of a model, and signal completion even on failure, which its tests then show."""
    subprocess.run([sys.executable, str(HERE / "compile_kernels.py"), model, *called], check=False)
    (folder / model).touch()


@pytest.fixture(scope="module", autouse=True)
def compiled_kernels(request: pytest.FixtureRequest, wait_for_kernels: Callable[[Collection[str]], None]) -> None:
    """Wait for the kernels that all tests of a module run."""
    if share_of_kernels(request.path) == 2:
        wait_for_kernels(models_of(request.path))
