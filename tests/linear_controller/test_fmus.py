"""The FMU of a linear controller: its native flavours are equal to the core to the last bit."""

from pathlib import Path

import fmpy
import numpy as np
import pytest
from code_blocks import example_of
from fmpy.validation import validate_fmu
from model_cases import CASES, core_outputs, laws_over_speed
from raw import Library, Library3

pytest.importorskip("ziglang", reason="a native FMU is compiled by ziglang: pip install 'amb-cosim[native]'")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """FMU for a version of FMI, and the folder that it is extracted to."""

    def build(fmi):
        path = laws_over_speed().build(tmp_path_factory.mktemp(f"fmi{fmi}"), fmi=fmi)
        return path, Path(fmpy.extract(str(path), str(path.parent / "extracted")))

    return {fmi: build(fmi) for fmi in (2, 3)}


def names_of(case):
    return [v.name for v in case.model.interface.of("output")]


def test_native_fmu_equals_the_core_to_the_last_bit(built):
    case = CASES["linear_controller"]
    for parameters, expected in zip(case.runs, core_outputs("linear_controller"), strict=True):
        with Library(built[2][1]).instantiate() as fmu:
            fmu.begin(**{name.replace(".", "__"): value for name, value in parameters.items()})
            for n in range(case.steps):
                assert fmu.set(**{k.replace(".", "__"): v for k, v in case.inputs(n).items()}) == 0
                assert fmu.step(n, case.h) == 0, fmu.log
                np.testing.assert_array_equal(fmu.get(*names_of(case)), expected[n])


def test_fmi_3_gives_the_same_and_shows_states_as_an_array(built):
    case, expected = CASES["linear_controller"], core_outputs("linear_controller")[0]
    with Library3(built[3][1]).instantiate() as fmu:
        fmu.begin()
        for n in range(case.steps):
            assert fmu.set(**{k.replace(".", "__"): v for k, v in case.inputs(n).items() if "scale" not in k}) == 0
            assert fmu.step(n, case.h) == 0, fmu.log
            np.testing.assert_array_equal(fmu.get("u.x", "u.y", "states"), [*expected[n][3:5], *expected[n][5:9]])


@pytest.mark.parametrize("fmi", [2, 3])
def test_description_is_valid(built, fmi):
    assert validate_fmu(str(built[fmi][0])) == []


def test_the_code_of_the_readme_prints_its_stated_output(run_python, tmp_path):
    block = example_of("linear_controller")
    last = run_python(f"{block}\nresult = float(steps['mb1.i_x'][-1])", cwd=tmp_path)
    assert f"# {last:.4f} A" in block
