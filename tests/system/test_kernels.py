"""What the kernels promise to the native build: they allocate nothing while they step."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

CASES = {
    "rotor_contact": ("rotor_contact.plant", {"Omega": 260.0, "d1.u": 0.3, "rb1.mu": 0.3, "rb2.mu": 0.3}),
    "amb_actuator": ("amb_actuator.actuator", {"mb1.x": 1e-4, "mb1.i_x": 20.0}),
    "rolac_controller": ("rolac_controller.controller", {"s5": 1e-4, "Omega": 400.0, "rolac_enable": 1.0}),
}


def allocations(module: str, start: dict[str, float], counts: list[int]) -> list[int]:
    """Allocations of numba's runtime during so many steps in one compiled loop."""
    import importlib
    import os

    os.environ["NUMBA_NRT_STATS"] = "1"
    import numba
    import numpy as np
    from numba.core.runtime import rtsys

    from fmi_export.model import Instance
    from orchestrator.build import MODELS

    model, constants = MODELS[module.split(".")[0]](None)
    assert model is importlib.import_module(module).MODEL
    step, turns = model.step, model.interface.position.get("theta")

    @numba.njit(error_model="numpy")
    def run(steps, constants, parameters, inputs, state, work, outputs, theta):
        for n in range(steps):
            if theta >= 0:
                inputs[theta] = n * 250e-6 * 400.0
            if step(constants, parameters, inputs, state, work, outputs, n * 250e-6, 250e-6) != 0:
                return n
        return steps

    made = []
    for steps in counts:
        instance = Instance(model, constants)
        for name, value in start.items():
            instance[name] = value
        instance.initialise()
        arrays = (instance.constants, instance.parameters, instance.inputs, instance.state, instance.work)
        controller = module.startswith("rolac")
        theta = turns - model.interface.n_parameters if controller and turns is not None else -1
        outputs = np.zeros_like(instance.outputs)
        run(0, *arrays, outputs, theta)
        before = rtsys.get_allocation_stats().alloc
        assert run(steps, *arrays, outputs, theta) == steps
        made.append(rtsys.get_allocation_stats().alloc - before)
    return made


@pytest.mark.parametrize("name", CASES)
def test_a_step_allocates_nothing(name: str, run_python: Callable[..., Any]) -> None:
    pytest.importorskip("numba")
    module, start = CASES[name]
    few, many = run_python(allocations, module=module, start=start, counts=[1, 400], timeout=300)
    assert many == few
