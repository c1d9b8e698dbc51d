"""What FMUs of flavour python have beyond the slave of both flavours: Python, which may fail, and several FMUs in it.

Every host is a subprocess: PythonFMU may harm the process that it runs in.
"""

import zipfile

import pytest
from binaries import read
from rig import ACTUATOR, ACTUATOR_CONSTANTS
from standard import STANDARD

from fmi_export.building.native.compiler import PLATFORMS, host_platform


def try_broken_resources(folder: str, place: str) -> list:
    import shutil
    from pathlib import Path

    from raw import Library

    library, answers = Library(Path(folder)), []
    for name, missing in (("a%20b", ""), ("c", "slavemodule.txt"), ("d", "probe_lag_fmu.py"), ("e", "constants.npy")):
        resources = shutil.copytree(Path(folder) / "resources", Path(place) / name)
        if missing:
            (resources / missing).unlink()
        fmu = library.instantiate(resources=str(resources), logging=0)
        answers.append([fmu.pointer, *fmu.log])
    fmu = library.instantiate().begin(u=1.0)
    return [*answers, [fmu.step(0), fmu.free()]]


def test_resources_that_python_cannot_use_are_refused_with_the_reason(fmu, run_python, tmp_path):
    *refusals, run = run_python(try_broken_resources, folder=fmu, place=tmp_path)
    sentences = [
        "PythonFMU cannot read a folder with %%20 in its path: ",  # for a printf
        "slavemodule.txt: No such file or directory",
        "probe_lag_fmu.py: No such file or directory",
        "FileNotFoundError(2, 'No such file or directory')",
    ]
    for (pointer, (status, category, text)), sentence in zip(refusals, sentences, strict=True):
        assert (pointer, status, category) == (None, 3, "logStatusError")
        assert sentence in text
    assert run == [0, None], "the process lives on"


def run_without_resources(folder: str) -> list:
    import shutil
    from pathlib import Path

    from raw import Library

    with Library(Path(folder)).instantiate().begin(u=1.0) as fmu:
        answer = [fmu.step(0)]
        shutil.rmtree(folder)
        return [*answer, fmu.step(1), fmu.call("Reset"), fmu.begin(u=1.0).step(0), fmu.get("steps"), fmu.log]


def test_an_instance_needs_no_resources_after_instantiation(build_fmu, lag, run_python, tmp_path):
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        archive.extractall(tmp_path)
    assert run_python(run_without_resources, folder=tmp_path) == [0, 0, 0, 0, [1], []]


def raise_in_python(folder: str, method: str, text: str) -> list:
    import sys
    from dataclasses import replace
    from pathlib import Path

    from raw import Library

    def fails(*_: object) -> int:
        raise ArithmeticError(*filter(None, [text]))

    library = Library(Path(folder))
    with library.instantiate().begin(u=1.0) as other:
        slave = sys.modules["probe_lag_fmu"].ProbeLag
        model = slave.model
        if method == "step":
            slave.model = replace(model, step=fails)
        else:
            setattr(slave, method, fails)
        answers = []
        with library.instantiate().begin(u=1.0) as fmu:
            for _ in range(2):
                answers.append([fmu.step(0), fmu.reason(), *fmu.get("fault_code"), fmu.call("Reset"), fmu.enter()])
                answers[-1].append(fmu.call("ExitInitializationMode"))
            answers.append(fmu.log[0])
        if method == "step":
            slave.model = model
            answers.append(other.step(0))
        return answers


@pytest.mark.parametrize(("text", "reason"), [("100 % wrong", "100 % wrong"), ("", "ArithmeticError()")])
def test_an_exception_in_a_kernel_is_a_fault_of_its_instance_alone(fmu, run_python, text, reason):
    *steps, logged, other = run_python(raise_in_python, folder=fmu, method="step", text=text)
    assert steps == [[3, reason, 998, 0, 0, 0]] * 2, "a reset leads out of it"
    assert logged == [3, "logStatusError", f"at t = 0 s: {reason}".replace("%", "%%")]
    assert other == 0


def test_an_uncaught_exception_is_the_reason_of_all_later_errors(fmu, run_python):
    first, second, logged = run_python(raise_in_python, folder=fmu, method="do_step", text="lost")
    reason = "ArithmeticError('lost')"
    assert first == [3, reason, 998, 0, 0, 3], "Python is not called any more"
    assert second[0] == 3
    assert logged == [3, "logStatusError", f"at t = 0 s: {reason}"]


@pytest.mark.slow
def test_two_hundred_instances_one_after_another_leave_the_process_alive(build_fmu, run_python):
    def host(path: str) -> list:
        import sys

        from raw import Library

        library, answers = Library(path), set()
        for _ in range(200):
            with library.instantiate().begin(mb1__x=1e-4) as fmu:
                fmu.step(0)
                answers.add(fmu.get("mb1.f_x")[0])
        return [len(answers), len(sys.path)]

    answers, entries = run_python(host, path=build_fmu(ACTUATOR, ACTUATOR_CONSTANTS))
    assert answers == 1
    assert entries < 20, "sys.path must not grow with every instance"


def test_the_guard_has_the_functions_of_the_standard_and_no_python(build_fmu, lag):
    here = host_platform()
    with zipfile.ZipFile(build_fmu(lag)) as archive:
        names = {name for name in archive.namelist() if name.startswith("binaries/")}
        suffix = PLATFORMS[here][0]
        assert names == {f"binaries/{here}/probe_lag{suffix}", f"binaries/{here}/probe_lag_pythonfmu{suffix}"}
        (guard,) = read(archive.read(f"binaries/{here}/probe_lag{suffix}"))
    assert guard.exports == STANDARD
    assert not [name for name in guard.imports if name.startswith(("Py", "_Py"))]
