"""Files of arrays are read by a process that imports nothing from the folder they lie in."""

import ast
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from amb_cosim.controllers.array_file import read_arrays

PACKAGES = ("amb_cosim", "amb_files", "fmi_export", "rotor_analysis")


def test_a_module_beside_a_mat_file_is_not_imported(tmp_path, monkeypatch):
    path = tmp_path / "law.mat"
    savemat(path, {name: np.eye(2) for name in "ABCD"} | {"Ts": 1e-4})
    for module in ("numpy", "scipy", "json"):
        (tmp_path / f"{module}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\nraise SystemExit('it ran')\n")
    monkeypatch.chdir(tmp_path)
    assert read_arrays(path)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("package", PACKAGES)
def test_each_python_that_is_started_leaves_its_folder_out_of_its_path(package):
    """`sys.executable` is followed by -P wherever it begins a command."""
    (folder,) = find_spec(package).submodule_search_locations
    for file in Path(folder).rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.List) and node.elts and ast.unparse(node.elts[0]) == "sys.executable":
                assert ast.unparse(node.elts[1]) == "'-P'", f"{file}:{node.lineno}"
    assert sys.version_info >= (3, 11), "-P is there"
