"""Each FMU contains the code it needs: the Python that loads it needs numpy only."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PROJECT = ["fmi_export", "rotor_contact", "amb_actuator", "rolac_controller", "amb_cosim"]
NEEDLESS = ["numba", "scipy", "pint", "pydantic", "xarray", "control", "pythonfmu"]

# Start values that give every FMU something to do; the rotor is thrown against its end bush.
START: dict[str, dict[str, float]] = {
    "rotor_contact": {"Omega": 260.0, "d1.u": 0.3, "mb1.k_b": 1e6, "mb2.k_b": 1e6, "rb1.mu": 0.1, "rb2.mu": 0.2},
    "amb_actuator": {"mb1.x": 1e-4, "mb1.i_x": 1.0, "mb2.i_y": 20.0},
    "rolac_controller": {"s5": 1e-4, "Omega": 0.0},
}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    from amb_cosim import build

    return {path.stem: path for path in build(tmp_path_factory.mktemp("fmus"), "python")}


def simulated(path: str, start: dict[str, float], hidden: list[str]) -> list[list[float]]:
    from hide import hide

    hide(*hidden)
    import fmpy

    names = [v.name for v in fmpy.read_model_description(path).modelVariables if v.causality == "output"]
    result = fmpy.simulate_fmu(
        path, stop_time=0.02, step_size=250e-6, output_interval=250e-6, start_values=start, output=names
    )
    return [[float(row[name]) for name in names] for row in result]


@pytest.mark.slow
@pytest.mark.parametrize("name", START)
def test_an_fmu_gives_the_same_numbers_with_numpy_alone(
    name: str, fmus: dict[str, Path], run_python: Callable[..., Any]
) -> None:
    compiled = np.array(run_python(simulated, path=fmus[name], start=START[name], hidden=[], timeout=300))
    plain = np.array(run_python(simulated, path=fmus[name], start=START[name], hidden=PROJECT + NEEDLESS, timeout=300))
    assert compiled.shape == plain.shape
    scale = np.maximum(np.abs(compiled).max(axis=0), 1e-300)
    assert np.abs((compiled - plain) / scale).max() < 1e-9
    if name == "rotor_contact":
        from amb_cosim.design.plant_data import plant

        outputs = [v.name for v in plant()[0].interface.of("output")]
        assert plain[:, outputs.index("eb1.mode")].max() > 0.0
