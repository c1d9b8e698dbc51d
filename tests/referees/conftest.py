"""Runs Siconos, and lets the tests of this folder import modules beside them."""

import subprocess
import sys
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from benchmarks.process import ENVIRONMENT, find_python_with

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))


@pytest.fixture(scope="session")
def siconos(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., dict[str, np.ndarray]]:
    """`siconos(scheme, timeout=60, **given)`: a scheme of `siconos_rotor` in a separate process."""
    siconos_rotor = str(files("benchmarks") / "siconos_rotor.py")
    python = find_python_with("siconos.kernel")  # Debian's package is for the system's Python alone
    if python is None:
        pytest.skip("no python3 on the PATH has Siconos (Debian: apt install python3-siconos)")

    # Processor features that numpy disables here (tools/arithmetic) may be unknown to an older one, which then warns.
    environment = {name: value for name, value in ENVIRONMENT.items() if name != "NPY_DISABLE_CPU_FEATURES"}

    def run(scheme: str, timeout: float = 60.0, **given) -> dict[str, np.ndarray]:
        folder = tmp_path_factory.mktemp("siconos")
        np.savez(folder / "given.npz", scheme=scheme, **given)
        command = [python, "-I", siconos_rotor, "given.npz", "answer.npz"]
        process = subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, text=True, timeout=timeout, check=False
        )
        printed = process.stdout[-4000:] + process.stderr[-4000:]
        assert process.returncode == 0, f"the process ended with {process.returncode}:\n{printed}"
        assert not printed, f"a solver that fails only says so:\n{printed}"
        with np.load(folder / "answer.npz") as answer:
            return dict(answer)

    return run
