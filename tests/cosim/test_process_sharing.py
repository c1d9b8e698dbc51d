"""FMUs that cannot share a process with others: each runs in a separate one."""

import subprocess
import sys
import zipfile

import numpy as np
import pytest
from fmu_systems import write_system
from informed import informed_fmu
from slow import slow_but_first

import amb_cosim
from amb_cosim.cosim.errors import ProcessFailed
from amb_cosim.cosim.fmu.fmu_description import read_interface
from amb_cosim.cosim.fmu.separate_component import SeparateComponent
from tests.ssp.gain_archives import SOURCE, description
from tests.support.c_fmus import DEFAULTS
from tests.support.messages import raises_naming

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the FMU is compiled for Linux")
GAIN_OF_B = """[parameters.b]
k = 10.0
[experiment.inputs]
"a.u" = 1.0
"b.u" = 1.0
"""
SCRIPT = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
import gains

class {name}(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y = 0.0, 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y = gains.GAIN * self.u
        return True
"""


@pytest.fixture(params=slow_but_first([2, 3]), ids="FMI {}".format)
def two_instances(request, fmu_from_c, tmp_path):
    """`two_instances(once, coupling, **options)`: a run of two instances of an FMU that counts those of its process."""

    def simulate(once, coupling="gauss_seidel", **options):
        fmu = informed_fmu(fmu_from_c, tmp_path, request.param, canBeInstantiatedOnlyOncePerProcess=once)
        both = {"a": fmu, "b": fmu}
        path = write_system(tmp_path, both, more=GAIN_OF_B, step="0.1 s", end="1 s", coupling=coupling)
        return amb_cosim.simulate(path, **options)

    return simulate


def test_an_fmu_limited_to_one_instance_per_process_is_isolated(two_instances):
    # Reported publicly for INTO-CPS_Application (11, 17) and FMIKit-Simulink (326).
    data = two_instances("true").dataset
    assert [set(data[f"{name}.instances"].values) for name in "ab"] == [{1.0}, {1.0}]
    assert [data[f"{name}.y"].values[-1] for name in "ab"] == pytest.approx([1.0, 10.0])
    shared = two_instances("false").dataset
    assert {*shared["a.instances"].values, *shared["b.instances"].values} == {1.0, 2.0}
    for name in ("a.y", "b.y", "b.stop", "b.reached"):
        np.testing.assert_array_equal(data[name], shared[name])


@pytest.mark.slow
def test_an_isolated_instance_repeats_steps_and_continues(two_instances):
    whole = two_instances("true", "iterative", save_at=["0.5 s"])
    later = two_instances("true", "iterative", start=whole.checkpoint("0.5 s"))
    np.testing.assert_array_equal(whole.dataset["b.y"], later.dataset["b.y"])


def test_error_names_an_fmu_that_exits_its_process(hostile, unpack):
    folder = unpack(hostile.fmu(2))
    hostile.will("segv", 1, "DoStep")
    component = SeparateComponent("motor", folder, read_interface(folder, "motor"), ["u"], ["y"], {})
    component.enter(0.0)
    component.leave()
    component.step(0.0, 0.1)
    component.read()
    assert component.outputs[0] == 0.1
    with raises_naming(ProcessFailed, "process of motor", "SIGSEGV"):
        component.step(0.1, 0.1)
    component.close()
    assert not hostile.processes()


def last_outputs(folder, parts, **inputs):
    """The output of each FMU at the end of a run of all of them."""
    settings = {f"{name}.{variable}": value for name in parts for variable, value in inputs.items()}
    data = amb_cosim.simulate(write_system(folder, parts, step="0.1 s", end="0.3 s"), set=settings).dataset
    return [float(data[f"{name}.y"].values[-1]) for name in parts]


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """`scripts(gains)`: last outputs of Python FMUs of one system, whose helper modules have the same name."""
    from pythonfmu.builder import FmuBuilder

    def simulate(gains: dict[str, float]) -> list[float]:
        parts = {}
        for name, gain in gains.items():
            folder = tmp_path / name
            folder.mkdir()
            (folder / "part.py").write_text(SCRIPT.format(name=name), encoding="utf-8")
            (folder / "gains.py").write_text(f"GAIN = {gain}\n", encoding="utf-8")
            for module in ("part", "gains"):  # which the builder imports
                monkeypatch.delitem(sys.modules, module, raising=False)
            parts[name] = FmuBuilder.build_FMU(folder / "part.py", dest=folder, project_files=[folder / "gains.py"])
        return last_outputs(tmp_path, parts, u=1.0)

    return simulate


def test_each_python_fmu_imports_its_bundled_modules(scripts):
    # Reported publicly for PythonFMU (97, 228); here the scripts, too, have one name.
    assert scripts({"Pump": 2.0, "Valve": 3.0, "Tank": 4.0}) == [2.0, 3.0, 4.0]


@pytest.fixture
def linked(tmp_path):
    """`linked(gains)`: last outputs of FMUs of one system, each with a library `libpart.so` that has its gain."""
    pytest.importorskip("ziglang", reason="the FMU is compiled by ziglang: pip install 'amb-cosim[native]'")
    text = (
        SOURCE.read_text(encoding="utf-8")
        .replace("self[GAIN] *", "part() *")
        .replace("enum", "double part(void);\nenum", 1)
    )

    def compile_to(library, code, *more):
        source = library.with_suffix(".c")
        source.write_text(code, encoding="utf-8")
        command = [sys.executable, "-m", "ziglang", "cc", "-shared", "-fPIC", "-fno-sanitize=all", "-w", *more]
        subprocess.run([*command, "-o", library, source], check=True, capture_output=True)

    def simulate(gains):
        parts = {}
        for name, gain in gains.items():
            folder = tmp_path / name
            folder.mkdir()
            part = folder / "libpart.so"
            compile_to(part, f"double part(void) {{ return {gain}; }}", "-Wl,-soname,libpart.so")
            compile_to(
                folder / "gain.so", text, DEFAULTS, "-DFMI_VERSION=2", "-Wl,-rpath,$ORIGIN", f"-L{folder}", "-lpart"
            )
            parts[name] = tmp_path / f"{name}.fmu"
            with zipfile.ZipFile(parts[name], "w") as fmu:
                fmu.writestr("modelDescription.xml", description())
                for library in (folder / "gain.so", part):
                    fmu.write(library, f"binaries/linux64/{library.name}")
        return last_outputs(tmp_path, parts)

    return simulate


def test_each_fmu_loads_its_bundled_libraries(linked):
    """The loader of the system knows a library by its name."""
    assert linked({"pump": 2.0, "valve": 3.0, "tank": 2.0}) == [2.0, 3.0, 2.0]
