"""The code that an FMU contains, and the code that it runs: the installed package, its copy, or none."""

import ast
import importlib
import json
import os
import shutil
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rig import ACTUATOR

from fmi_export import amb_cosim_bootstrap as bootstrap
from fmi_export.building.python_fmu import build_python_fmu
from tests.support.messages import assert_names, raises_naming

# What an FMU may import besides its own packages, numba and filelock where they are there; slave.py imports the
# description only when the FMU is built.
RUNTIME = {"filelock", "numpy", "numba", "pythonfmu", "amb_cosim_bootstrap", *sys.stdlib_module_names}
ONLY_BUILDS = ("code/fmi_export/slave.py", "fmi_export.building.description")


def models() -> dict:
    from amb_cosim.model_constants.plant_data import plant
    from amb_cosim.model_constants.rotor_models import actuator, controller

    return {"amb_actuator": actuator(), "rolac_controller": controller(), "rotor_contact": plant()}


def imports(source: str) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "absolute imports alone"
            found.add(node.module or "")
    return found


@pytest.mark.parametrize("name", ["rotor_contact", "amb_actuator", "rolac_controller"])
def test_fmu_contains_no_module_that_only_the_host_needs(name, build_fmu):
    with zipfile.ZipFile(build_fmu(*models()[name])) as archive:
        sources = {
            path.removeprefix("resources/"): archive.read(path).decode()
            for path in archive.namelist()
            if path.endswith(".py") and not path.startswith("resources/pythonfmu/")
        }
    packages = {path.split("/")[1] for path in sources if path.startswith("code/")}
    assert packages == set(models()[name][0].packages)
    assert not [path for path in sources if "building" in path]
    for path, source in sources.items():
        for module in imports(source):
            if (path, module) != ONLY_BUILDS:
                assert module.split(".")[0] in RUNTIME | packages, f"{path} imports {module}"
                assert not module.startswith("fmi_export.building"), f"{path} imports {module}"


def inputs() -> list[list[float]]:
    rng = np.random.default_rng(1)
    return [[float(rng.uniform(-4, 4)), float(rng.integers(2))] for _ in range(30)]


def run_lag(path: str, inputs: list, hidden: list) -> list:
    import sys

    from hide import hide

    hide(*hidden)
    from raw import Library

    library, rows = Library(path), []
    with library.instantiate().begin() as fmu:
        for n, (u, hold) in enumerate(inputs):
            fmu.set(u=u, hold=hold)
            rows.append([fmu.step(n), *fmu.get(*library.outputs)])
    lag = sys.modules["probe_lag.lag"]
    compiled = hasattr(lag.step, "py_func")
    return [rows, lag.__file__, compiled]


def changed_copy(path: Path, folder: Path) -> Path:
    """The FMU, built from code that differs from the installed one by a comment."""
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder / "tree")
    resources = folder / "tree" / "resources"
    with (resources / "code" / "probe_lag" / "lag.py").open("a") as source:
        source.write("# another version\n")
    facts = json.loads((resources / "build.json").read_text())
    facts["packages"]["probe_lag"] = bootstrap.digest(resources / "code" / "probe_lag")
    (resources / "build.json").write_text(json.dumps(facts))
    packed = shutil.make_archive(str(folder / "changed"), "zip", folder / "tree")
    return Path(packed).rename(folder / "probe_lag.fmu")


@pytest.fixture(scope="module")
def installed_run(build_fmu, lag, run_python):
    return run_python(run_lag, path=build_fmu(lag), inputs=inputs(), hidden=[])


def test_the_installed_package_is_used_if_its_code_is_the_same(installed_run):
    rows, file, compiled = installed_run
    assert "resources" not in Path(file).parts
    assert compiled
    assert {row[0] for row in rows} == {0}


@pytest.mark.parametrize("has_numba", [True, False])
def test_shipped_code_gives_the_same_numbers_as_installed_packages(
    build_fmu, lag, run_python, installed_run, has_numba
):
    hidden = ["probe_lag", "fmi_export", *([] if has_numba else ["numba"])]
    rows, file, compiled = run_python(run_lag, path=build_fmu(lag), inputs=inputs(), hidden=hidden)
    assert Path(file).parts[-4:] == ("resources", "code", "probe_lag", "lag.py")
    assert compiled == has_numba
    assert rows == installed_run[0]


@pytest.mark.slow
def test_an_fmu_runs_its_bundled_code_if_none_is_loaded(build_fmu, lag, run_python, installed_run, tmp_path):
    changed = changed_copy(build_fmu(lag), tmp_path)
    rows, file, _ = run_python(run_lag, path=changed, inputs=inputs(), hidden=[])
    assert "resources" in Path(file).parts
    assert rows == installed_run[0]


@pytest.mark.slow
def test_fmu_of_other_code_than_is_loaded_is_refused(build_fmu, lag, run_python, tmp_path):
    def host(path: str, changed: str) -> list:
        from raw import Library

        library = Library(path)
        running, other = library.instantiate().begin(u=1.0), Library(changed)
        refused = [other.instantiate() for _ in range(5)]
        statuses = [running.step(n) for n in range(20)]
        statuses.append(library.instantiate().begin(u=1.0).step(0))
        return [statuses, [[fmu.pointer, fmu.log[0][2]] for fmu in refused]]

    path = build_fmu(lag)
    statuses, refused = run_python(host, path=path, changed=changed_copy(path, tmp_path))
    assert set(statuses) == {0}
    for pointer, reason in refused:
        assert pointer is None
        assert_names(reason, "another version of probe_lag", "rebuild", "process")


@pytest.mark.slow
def test_an_fmu_runs_again_after_the_folder_of_its_first_run_was_deleted(build_fmu, lag, run_python):
    def host(path: str) -> list:
        from hide import hide

        hide("probe_lag", "fmi_export")
        import fmpy

        runs = [
            fmpy.simulate_fmu(path, stop_time=0.01, step_size=1e-3, output_interval=1e-3, start_values={"u": 1.0})
            for _ in range(2)
        ]
        return [run["y"].tolist() for run in runs]

    first, second = run_python(host, path=build_fmu(lag))
    assert first == second
    assert first[-1] > 0.99


def test_an_fmu_finds_modules_of_a_package_whose_fmu_was_deleted(tmp_path, monkeypatch):
    """FMUs of one release have a package in common, of which each imports other modules."""
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    monkeypatch.setattr(bootstrap, "_running", {})
    for fmu in ("one", "two", "three"):
        code = tmp_path / fmu / "code"
        for file in ("shared/__init__.py", "shared/first.py", "shared/part/__init__.py", "shared/part/second.py"):
            (code / file).parent.mkdir(parents=True, exist_ok=True)
            (code / file).touch()
        facts = {"packages": {"shared": bootstrap.digest(code / "shared")}}
        (tmp_path / fmu / "build.json").write_text(json.dumps(facts))
    try:
        for fmu, module in (("one", "shared.part"), ("two", "shared.first"), ("three", "shared.part.second")):
            sys.path[0] = str(tmp_path / fmu)
            bootstrap.choose_code({})
            importlib.import_module(module)
            shutil.rmtree(tmp_path / fmu)
    finally:
        for name in [name for name in sys.modules if name.partition(".")[0] == "shared"]:
            del sys.modules[name]


@pytest.mark.skipif(sys.platform != "linux", reason="other systems refuse names that are no text")
def test_a_digest_includes_files_whose_names_are_no_text(tmp_path):
    empty = bootstrap.digest(tmp_path)
    (tmp_path / os.fsdecode(b"\xff.py")).write_bytes(b"")
    assert bootstrap.digest(tmp_path) != empty


def test_an_fmu_is_built_the_same_in_a_process_that_runs_it(build_fmu, lag, run_python, tmp_path):
    """The FMU contains the PythonFMU of the process, without the libraries added to an FMU."""

    def host(path: str, folder: str) -> list:
        import sys
        from pathlib import Path

        import numpy as np
        from raw import Library

        running = Library(path).instantiate().begin(u=1.0)
        from probe_lag.lag import MODEL

        from fmi_export.building.python_fmu import build_python_fmu

        built = build_python_fmu(MODEL, np.zeros(1), Path(folder))
        return [running.step(0), sys.modules["pythonfmu"].__file__, str(built)]

    path = build_fmu(lag)
    status, pythonfmu, built = run_python(host, path=path, folder=tmp_path)
    assert status == 0
    assert "resources" in Path(pythonfmu).parts
    assert Path(built).read_bytes() == path.read_bytes()


def test_error_names_the_path_of_a_missing_script(tmp_path):
    model = replace(ACTUATOR, name="unknown_model")
    with raises_naming(ValueError, "unknown_model", "unknown_model_fmu.py"):
        build_python_fmu(model, np.zeros(1), tmp_path)
    assert list(tmp_path.iterdir()) == []
