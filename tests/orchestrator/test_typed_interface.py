"""What type checkers, help() and users see of the package: types of all packages, its names and its version."""

import importlib.metadata
import pydoc
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import amb_cosim

ROOT = Path(__file__).parents[2]
SCRIPT = """
import numpy as np

import amb_cosim

version: str = amb_cosim.__version__
for speed in np.linspace(100.0, 200.0, 2):
    result: amb_cosim.Result = amb_cosim.run("drop", set={"Omega": float(speed)}, until=0.02)
    reached: float = result.summary.cycle_duration
amb_cosim.run("drop", until=[1.0])
"""


def test_every_package_of_the_wheel_declares_its_types():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    packages = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert len(packages) > 15
    assert [name for name in packages if not (ROOT / name / "py.typed").is_file()] == []


def test_the_version_is_that_of_the_installed_package():
    assert amb_cosim.__version__ == importlib.metadata.version("amb-cosim")


def test_help_lists_every_name():
    text = pydoc.plain(pydoc.render_doc(amb_cosim))
    assert {"run", "studies", "Result"} <= {*amb_cosim.__all__}
    assert [name for name in amb_cosim.__all__ if name not in text] == []


@pytest.mark.slow
def test_a_users_script_is_checked_with_the_types_of_the_package(tmp_path):
    """mypy --strict finds the one wrong argument, and no missing types."""
    pytest.importorskip("mypy")
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache"), "script.py"]
    found = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stdout.splitlines()
    assert len(found) == 2, found  # the error, and the count of errors
    assert "script.py:10" in found[0]
    assert '"until"' in found[0]
