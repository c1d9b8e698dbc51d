"""Four displacement sensors, each a first-order lag: tau m' + m = s, m = s at the start.

The displacement s is constant during a step h, so that m(t + h) = s + (m(t) - s) exp(-h/tau) is exact.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from fmi_export.interface import interface, repeated
from fmi_export.jit import kernel
from fmi_export.model import Array, Model
from fmi_export.variables import Variable, input_, output, parameter

N_SENSORS = 4


def _sensor(number: int) -> list[Variable]:
    return [
        input_(f"true{number}", "m", f"Displacement at sensor {number}", field="s"),
        output(f"m{number}", "m", f"Signal of sensor {number}", field="m"),
    ]


INTERFACE = interface(
    parameter("time_constant", "s", "Time constant tau of every sensor", 50e-6, minimum=1e-9),
    *repeated("sensors", [(k + 1,) for k in range(N_SENSORS)], _sensor),
    output("fault_code", "1", "0 while all is well", type="Integer"),
)
PARAMETERS, INPUTS, OUTPUTS = INTERFACE.records


@kernel
def initialise(constants: Array, parameters: Array, inputs: Array, state: Array, work: Array, outputs: Array) -> int:
    """Signals at rest at the first displacements."""
    u, y = inputs.view(INPUTS)[0], outputs.view(OUTPUTS)[0]
    for k in range(N_SENSORS):
        state[k] = y.sensors[k].m = u.sensors[k].s
    return 0


@kernel
def step(
    constants: Array,
    parameters: Array,
    inputs: Array,
    state: Array,
    work: Array,
    outputs: Array,
    time: float,
    step_size: float,
) -> int:
    """Advance all sensors by `step_size` (s)."""
    p, u, y = parameters.view(PARAMETERS)[0], inputs.view(INPUTS)[0], outputs.view(OUTPUTS)[0]
    remainder = math.exp(-step_size / p.time_constant)
    for k in range(N_SENSORS):
        s = u.sensors[k].s
        state[k] = y.sensors[k].m = s + (state[k] - s) * remainder
    return 0


MODEL = Model(
    name="lag_sensor",
    description="Four displacement sensors with a lag",
    interface=INTERFACE,
    initialise=initialise,
    step=step,
    n_state=N_SENSORS,
    n_work=0,
    packages=("lag_sensor", "fmi_export"),
)


def source(**_: Any) -> tuple[Model, Array]:
    """The model and its constants, of which it has none."""
    return MODEL, np.zeros(1)
