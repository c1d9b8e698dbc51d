"""Each model as an FMU: valid, equal to its core to the last bit, compiled or not, and saved states."""

import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from model_cases import CASES, Case, core_outputs
from raw import OK, Library, Slave

from rolac_controller.enumerations import ADAPTING, IDENTIFYING, NO_WINDOW, NOT_STARTED, SENSOR_SUSPECT, SLOT_BEFORE

SUPPORT = Path(__file__).parents[1] / "support"

models = pytest.mark.parametrize("name", CASES)


@pytest.fixture
def library_of(build_fmu: Callable[..., Path], unpack: Callable[[Path], Path]) -> Callable[[Case], Library]:
    return lambda case: Library(unpack(build_fmu(case.model, case.constants)))


def named(values: dict[str, float]) -> dict[str, float]:
    return {name.replace(".", "__"): value for name, value in values.items()}


def run(fmu: Slave, case: Case, first: int, last: int) -> list[list[float]]:
    """Outputs after the steps from `first` to before `last`."""
    rows = []
    for n in range(first, last):
        fmu.set(**named(case.inputs(n)))
        assert fmu.step(n, case.h) == 0, fmu.log
        rows.append(fmu.get(*fmu.library.outputs))
    return rows


@models
def test_fmu_equals_the_core_to_the_last_bit(name: str, library_of: Callable[[Case], Library]) -> None:
    case = CASES[name]
    for parameters, expected in zip(case.runs, core_outputs(name), strict=True):
        with library_of(case).instantiate().begin(**named(parameters)) as fmu:
            np.testing.assert_array_equal(run(fmu, case, 0, case.steps), expected, err_msg=str(parameters))


@models
def test_serialised_state_restores_the_run(name: str, library_of: Callable[[Case], Library]) -> None:
    """Here and in another instance, from the middle of a run on."""
    case = CASES[name]
    half, end = case.steps // 2, case.steps // 2 + 40
    fmu, other = (library_of(case).instantiate().begin(**named(case.runs[-1])) for _ in range(2))
    with fmu, other:
        run(fmu, case, 0, half)
        saved = fmu.save()
        text = fmu.serialise(saved)
        first = run(fmu, case, half, end)
        assert [fmu.restore(saved), other.restore(other.deserialise(text)[1])] == [OK, OK]
        assert run(fmu, case, half, end) == run(other, case, half, end) == first
        assert first[0] != first[-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["amb_actuator", "rolac_controller", "rotor_contact"])
def test_plain_python_equals_compiled_kernels(name: str, run_python: Callable[..., Any]) -> None:
    """To the last bit where both call the same C library for sine, exponential and so on."""
    pytest.importorskip("numba")

    def run_plain(name: str, support: str) -> list[Any]:
        import sys

        from hide import hide

        hide("numba")
        sys.path.insert(0, support)
        from model_cases import core_outputs

        from fmi_export.jit import COMPILED

        return [COMPILED, core_outputs(name).tolist()]

    compiled, result = run_python(run_plain, timeout=600, name=name, support=str(SUPPORT))
    assert not compiled
    expected = core_outputs(name)
    scale = np.abs(expected).max(axis=(0, 1)) + 1e-300
    largest = np.abs((result - expected) / scale).max()
    assert largest == 0.0 if platform.system() == "Linux" else largest < 1e-9


def visited(name: str, run: int, *outputs: str) -> set[Any]:
    """Values, or tuples of them, that outputs have in one run."""
    columns = [CASES[name].model.interface.index("output", output) for output in outputs]
    return {tuple(row) if len(outputs) > 1 else row[0] for row in core_outputs(name)[run][:, columns].tolist()}


def test_the_runs_cover_all_contact_and_control_modes() -> None:
    for flag in ("clipped_x", "saturated_y", "voltage_limited_x"):
        assert visited("amb_actuator", 10, f"mb2.{flag}") == {0.0, 1.0}
    for mode in range(4):
        assert visited("rolac_controller", mode, "rolac_status", "identification_state") == {
            (NO_WINDOW, NOT_STARTED),
            (ADAPTING, NOT_STARTED),
            (IDENTIFYING, SLOT_BEFORE),
            (SENSOR_SUSPECT, SLOT_BEFORE),
        }
        assert max(visited("rolac_controller", mode, "mb1.contact_share")) > 0.0
    modes = [visited("rotor_contact", 0, f"{site}.mode") for site in ("rb1", "rb2", "eb1", "eb2")]
    assert set().union(*modes) >= {0.0, 1.0}
    for name in CASES:
        assert visited(name, 0, "fault_code") == {0.0}
