"""The FMU: validation, equality with the core to the last bit, state, and plain Python against compiled kernels."""

import itertools

import numpy as np
import pytest
from fmpy.validation import validate_fmu
from rig import ACTUATOR, ACTUATOR_CONSTANTS

STEPS = 240
MODES = list(itertools.product(range(3), range(2), range(2)))  # force_law, amplifier, mean_current


@pytest.fixture(scope="module")
def fmu_file(build_fmu):
    return build_fmu(ACTUATOR, ACTUATOR_CONSTANTS)


def inputs_at(n):
    """Inputs of step n: every axis in and out of its limits, and each fault for a while."""
    given = {}
    for k, (b, a) in enumerate((b, a) for b in ("mb1", "mb2") for a in "xy"):
        given[f"{b}.i_{a}"] = 6.0 * np.sin(0.05 * n * (k + 1)) if n % 40 < 30 else 0.1 * k
        given[f"{b}.command_voltage_{a}"] = 0.2 * np.cos(0.3 * n)
        given[f"{b}.{a}"] = 7e-4 * np.sin(0.031 * n + k)
        given[f"{b}.coil_loss_upper_{a}"] = 0.4 if 60 <= n < 90 else 0.0
        given[f"{b}.coil_loss_lower_{a}"] = 1.0 if 80 <= n < 100 else 0.0
        given[f"{b}.amplifier_off_{a}"] = float(110 <= n < 130 + k)
        given[f"{b}.stuck_{a}"] = float(150 <= n < 160 + k)
    return {name: float(value) for name, value in given.items()}


def from_core_alone(modes, schedule, hidden):
    """Whether kernels are compiled, and the outputs of the core in each mode; runs in a process of its own, too."""
    if hidden:
        from hide import hide

        hide(*hidden)

    import numpy as np

    from amb_actuator.actuator import model_for
    from fmi_export.jit import COMPILED
    from fmi_export.model import Instance

    model, found = model_for(["mb1", "mb2"]), []
    for mode in modes:
        made = Instance(model, np.array([2.0]))
        for name, value in zip(("force_law", "amplifier", "mean_current"), mode, strict=True):
            made[name] = value
        made.initialise()
        rows = []
        for n, inputs in enumerate(schedule):
            for name, value in inputs.items():
                made[name] = value
            made.step(n * 250e-6, 250e-6)
            rows.append([made[v.name] for v in model.interface.of("output")])
        found.append(rows)
    return [COMPILED, found]


@pytest.fixture(scope="module")
def schedule():
    return [inputs_at(n) for n in range(STEPS)]


@pytest.fixture(scope="module")
def from_core(schedule):
    _, found = from_core_alone(MODES, schedule, hidden=[])
    return dict(zip(MODES, map(np.array, found), strict=True))


def test_the_schedule_visits_what_there_is(from_core):
    names = [v.name for v in ACTUATOR.interface.of("output")]
    rows = from_core[2, 1, 0]
    for flag in ("clipped_x", "saturated_y", "voltage_limited_x"):
        column = rows[:, names.index(f"mb2.{flag}")]
        assert set(column) == {0.0, 1.0}
    assert rows[:, -1].max() == 0.0


def test_fmu_gives_bit_for_bit_what_the_core_gives(fmu_file, from_core, schedule, run_python):
    def host(path: str, modes: list, schedule: list) -> list:
        from drive import Fmu

        found = []
        for law, amplifier, mean in modes:
            fmu = Fmu(path, force_law=law, amplifier=amplifier, mean_current=mean)
            rows = []
            for n, inputs in enumerate(schedule):
                fmu.set(**inputs)
                assert fmu.step(n) == 0
                rows.append(fmu.outputs())
            found.append(rows)
            fmu.close()
        return found

    found = run_python(host, path=fmu_file, modes=MODES, schedule=schedule, timeout=120)
    for mode, rows in zip(MODES, found, strict=True):
        np.testing.assert_array_equal(np.array(rows, dtype=float), from_core[mode], err_msg=str(mode))


@pytest.mark.slow
def test_plain_python_gives_bit_for_bit_what_compiled_kernels_give(from_core, schedule, run_python):
    pytest.importorskip("numba")
    compiled, found = run_python(from_core_alone, modes=MODES, schedule=schedule, hidden=["numba"], timeout=120)
    assert not compiled
    for mode, rows in zip(MODES, found, strict=True):
        np.testing.assert_array_equal(np.array(rows), from_core[mode], err_msg=str(mode))


def test_saved_state_brings_back_the_currents(fmu_file, schedule, run_python):
    def host(path: str, schedule: list) -> list:
        from drive import Fmu

        fmu, other = Fmu(path, amplifier=1, force_law=2), Fmu(path, amplifier=1, force_law=2)
        for n in range(20):
            fmu.set(**schedule[n])
            fmu.step(n)
        saved = fmu.fmi.getFMUState()
        text = fmu.fmi.serializeFMUState(saved)
        other.fmi.setFMUState(other.fmi.deSerializeFMUstate(text))
        answer = []
        for one in (fmu, fmu, other):
            if one is fmu:
                fmu.fmi.setFMUState(saved)
            rows = []
            for n in range(20, 60):
                one.set(**schedule[n])
                one.step(n)
                rows.append(one.outputs())
            answer.append(rows)
        fmu.fmi.freeFMUState(saved)
        fmu.close()
        other.close()
        return answer

    first, again, elsewhere = run_python(host, path=fmu_file, schedule=schedule)
    assert first == again == elsewhere
    assert first[0] != first[-1]


def test_fault_of_the_input_reaches_the_log_and_the_fault_code(fmu_file, run_python):
    def host(path: str) -> list:
        from drive import Fmu

        fmu = Fmu(path, force_law=2)
        fmu.set(mb2__y=-1.3e-3)
        answer = [fmu.step(0), *fmu.get("fault_code", "mb2.f_y"), fmu.log[0]]
        fmu.close()
        return answer

    assert run_python(host, path=fmu_file) == [
        3,
        4,
        0.0,
        "at t = 0 s: mb2.y = -0.0013 m is not allowed; the rotor must stay within the air gap, |mb2.y| < 0.0012 m",
    ]


def test_validation_finds_no_problems(fmu_file):
    assert validate_fmu(str(fmu_file)) == []
