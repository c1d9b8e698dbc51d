"""Compiling the two kernels of a model in a separate process."""

import shutil
from pathlib import Path

import pytest

KERNELS = """
from fmi_export.jit import kernel

@kernel
def slope(parameters, inputs):
    return inputs[0] - parameters[0]

@kernel
def initialise(constants, parameters, inputs, state, work, outputs):
    outputs[0] = state[0]
    return 0

@kernel
def step(constants, parameters, inputs, state, work, outputs, time, step_size):
    state[0] += step_size * slope(parameters, inputs)
    outputs[0] = state[0]
    return 0
"""


def stepped(folder: str, executable: str = "") -> dict:
    """Step the model by 0.5 s at an input of 5 and a parameter of 2; return the output and what was compiled here."""
    import sys

    import numpy as np

    sys.path.insert(0, folder)
    sys.executable = executable or sys.executable
    from small_model import kernels

    from fmi_export.model_kernels import compile_model

    compile_model(kernels.initialise, kernels.step)
    constants, parameters, inputs, state, work, outputs = (
        np.array([value]) for value in (0.0, 2.0, 5.0, 0.0, 0.0, 0.0)
    )
    kernels.initialise(constants, parameters, inputs, state, work, outputs)
    kernels.step(constants, parameters, inputs, state, work, outputs, 0.0, 0.5)
    return {
        "output": outputs[0],
        "compiled": sum(sum(k.stats.cache_misses.values()) for k in (kernels.initialise, kernels.step)),
        "inner": len(kernels.slope.signatures),
    }


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder with the package of a model."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "machine_code"))
    package = tmp_path / "small_model"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "kernels.py").write_text(KERNELS)
    return tmp_path


def test_kernels_below_those_of_a_model_are_not_compiled_apart(model, run_python):
    assert run_python(stepped, folder=model) == {"output": 1.5, "compiled": 0, "inner": 0}


def test_a_host_that_is_not_python_compiles_kernels_itself(model, run_python):
    result = run_python(stepped, folder=model, executable="/bin/omsimulator")
    assert result == {"output": 1.5, "compiled": 2, "inner": 1}


def test_kernels_that_numba_cannot_compile_raise_its_error(model, run_python):
    file = model / "small_model" / "kernels.py"
    file.write_text(KERNELS.replace("inputs[0] - parameters[0]", "inputs[0] - unknown"))
    with pytest.raises(Exception, match="unknown"):
        run_python(stepped, folder=model)


def test_code_of_an_extracted_fmu_stays_compiled_when_the_fmu_is_deleted(model, run_python, monkeypatch):
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(model / "cache"))
    for run in ("first", "second"):
        code = model / run / "resources" / "code"
        shutil.copytree(model / "small_model", code / "small_model")
        (code.parent / "build.json").write_text("{}")
        assert run_python(stepped, folder=code)["output"] == 1.5
        shutil.rmtree(model / run)
    assert len(list((model / "cache").rglob("*.kernels.step*.nbc"))) == 1
