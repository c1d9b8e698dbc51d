"""Lowering numba's kernels to code that needs no Python: the result, and kernels that are refused."""

import importlib
import re

import numpy as np
import pytest
from slow import slow_but_first

from fmi_export.building.native.lowering import lower
from fmi_export.interface import interface
from fmi_export.model import Model
from fmi_export.variables import input_, output
from tests.support.messages import assert_names, raises_naming

pytestmark = pytest.mark.usefixtures("compiler")

TABLE = interface(input_("u", "1", "Input"), output("y", "1", "Output"), output("fault_code", "1", "F", type="Integer"))


def model_of(step, initialise=None):
    kernels = importlib.import_module("probe_python.kernels")
    step = getattr(kernels, step) if isinstance(step, str) else step
    return Model("probe_python", "", TABLE, initialise or kernels.nothing, step, 1, 6, ("probe_python", "fmi_export"))


@pytest.fixture(scope="module")
def assembly(lag):
    return lower(lag)


def test_the_code_exports_two_functions_and_calls_only_libm(assembly):
    assert re.findall(r"^define hidden [^@]*@(\w+)\(", assembly, re.MULTILINE) == ["kernel_initialise", "kernel_step"]
    assert re.findall(r"^define (?!hidden|internal).*", assembly, re.MULTILINE) == []
    declared = set(re.findall(r"^declare [^@]*@([\w.]+)\(", assembly, re.MULTILINE))
    assert {name for name in declared if not name.startswith("llvm.")} <= {"exp"}
    assert not re.search(r"\b_?Py\w+|NRT_|numba_", assembly)


def test_the_code_names_no_target_and_no_path(assembly):
    assert not re.search(r"^target |target-cpu|target-features|^source_filename", assembly, re.MULTILINE)
    assert not re.search(r"inttoptr|/\w+/", assembly)


@pytest.mark.slow
def test_lowering_again_gives_the_same_code(lag, assembly):
    assert lower(lag) == assembly


@pytest.mark.parametrize("kernel", slow_but_first(["allocate", "assign_overlapping", "raise_with_value"]))
def test_a_kernel_that_needs_the_runtime_of_numba_is_refused(kernel):
    with pytest.raises(ValueError, match=r"probe_python .*: a kernel must not allocate, .*kernels.py \(\d+\)"):
        lower(model_of(kernel))


def test_a_kernel_that_needs_python_is_refused_with_the_reason():
    with raises_naming(ValueError, "probe_python", "Python"):
        lower(model_of("print_it"))


def test_a_kernel_that_is_not_compiled_is_refused():
    with raises_naming(ValueError, "numba"):
        lower(model_of("plain"))


def test_a_kernel_that_cannot_be_found_by_name_is_refused():
    from fmi_export.jit import kernel

    @kernel
    def local(constants, parameters, inputs, state, work, outputs, time, step_size):
        return 0

    with pytest.raises(ValueError, match=r"there is no kernel \S+<locals>\.local in module"):
        lower(model_of(local))


@pytest.mark.parametrize(("u", "outcome"), [(5.0, 13.0), (2.0, 998)], ids=["well", "exception"])
def test_an_exception_in_a_kernel_becomes_a_fault_of_the_fmu(unpacked, u, outcome):
    from raw import ERROR, OK, Library

    with Library(unpacked(model_of("raise_plainly"))).instantiate().begin(u=u) as fmu:
        status = fmu.step(0)
        if outcome == 998:
            assert (status, fmu.get("fault_code")) == (ERROR, [998])
            assert_names(fmu.log[-1][2], "0 s", "exception")
        else:
            assert (status, fmu.get("y")) == (OK, [np.hypot(u, 12.0)])
