"""The plant of a body off its seat moves as all elements do: under forces, unbalance, weight and motion of the base.

Unbalance acts by the same rows as an external force of the body; weight and motion of the base by the same rows, too.
"""

import numpy as np
import pytest
from rotor_cases import STEEL

from amb_analysis.linear.rotor_and_magnets import rotor_component
from amb_cosim.model_constants.plant_data import plant
from rotor_analysis.assembly import assemble, on_bearings
from rotor_analysis.parts import Bearing, Body, Sensor
from rotor_analysis.rotor import ReductionOptions, Rotor
from rotor_analysis.shaft import Shaft

K_B, C_B, SPIN, OFFSET, TIP = 2e6, 2e3, 400.0, 0.12, 16  # N/m, N s/m, rad/s, m, row of x at the last node
TOLERANCE = {"none": 1e-9, "free_modes": 1e-3, "msdc": 3e-2}


def rotor(method, offset=OFFSET):
    shaft = Shaft(diameter=(0.04,), nodes=(0.0, 0.1, 0.3, 0.4, 0.5), **STEEL)
    bell = Body("bell", 5, 6.0, 0.03, 0.04, unbalance=True, offset=offset)
    held = tuple(Bearing(f"mb{k}", node) for k, node in ((1, 1), (2, 4)))
    reduction = ReductionOptions(method, masters=(1, 2, 3, 4, 5) if method == "msdc" else ())
    tip = (Sensor("tip", 5, "tip_x", "tip_y"),)
    return Rotor("overhung", shaft, (bell,), held, sensors=tip, reduction=reduction)


def of_plant(method, omega, source):
    """Displacement x + i y of the last node over a forward circle of inputs, from the constants of the FMU."""
    model, constants = plant(rotor(method))
    held = {f"mb{k}.{name}": value for k in (1, 2) for name, value in (("k_b", K_B), ("c_b", C_B))}
    part = rotor_component("plant", model.layout, constants, held, SPIN)
    inputs = [part.inputs.index(f"plant.{source}_{axis}") for axis in "xy"]
    outputs = [part.outputs.index(f"plant.tip_{axis}") for axis in "xy"]
    law = part.law
    H = law.C @ np.linalg.solve(1j * omega * np.eye(len(law.A)) - law.A, law.B[:, inputs] @ np.array([1.0, -1j]))
    return H[outputs[0]]


def of_elements(omega, load):
    """The same from the finite elements; load(M) is the force on x and x' of each node in turn, M their mass."""
    model = rotor("none").on_equal_bearings(K_B, C_B)
    full = on_bearings(assemble(model), model).at(SPIN)
    force = np.zeros(full.size, dtype=complex)
    force[::2] = load(full.M[::2, ::2])
    force[1::2] = -1j * force[::2]
    D = -(omega**2) * full.M + 1j * omega * (full.C + SPIN * full.G) + full.K
    return np.linalg.solve(D, force)[TIP]


@pytest.mark.parametrize("method", list(TOLERANCE))
@pytest.mark.parametrize("omega", [0.0, 150.0, 400.0])
def test_a_force_acts_at_the_centre_of_mass(method, omega):
    at_seat, at_centre = (of_elements(omega, lambda _, d=d: [0.0] * 8 + [1.0, d]) for d in (0.0, OFFSET))
    assert of_plant(method, omega, "bell.f") == pytest.approx(at_centre, rel=TOLERANCE[method])
    assert abs(at_seat / at_centre - 1.0) > 0.05


@pytest.mark.parametrize("method", list(TOLERANCE))
@pytest.mark.parametrize("omega", [0.0, 150.0])
def test_weight_and_motion_of_the_base_act_at_the_centre_of_mass(method, omega):
    """-M e, with e = 1 along x: its moment on the seat is -m d."""
    exact = of_elements(omega, lambda M: -M @ np.tile([1.0, 0.0], 5))
    assert of_plant(method, omega, "base.a") == pytest.approx(exact, rel=TOLERANCE[method])
    other = of_elements(omega, lambda M: -(M @ np.tile([1.0, 0.0], 5)) * np.tile([1.0, -1.0], 5))
    assert abs(other / exact - 1.0) > 0.05
