"""The compiled loop and the plain one record the same, to the last bit, with real FMUs of both flavours.

Every output of all three FMUs is compared: energies, currents, forces, contact modes, flags. The rotor touches its
retainer bearings in every scenario.
"""

import tomllib

import pytest

from amb_cosim.cosim.run.options import RunOptions
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import make_scenario
from amb_cosim.scenario.simulation import execute

pytestmark = pytest.mark.slow

UNBALANCE = """
description = "Unbalance comes and goes at 260 rad/s"
Omega = "260 rad/s"
settle_cycles = 3
end_cycle = 8

[inputs.rotor_contact]
"d1.u" = "0.5 g.m"

[[event]]
cycle = 1
set.rotor_contact."d1.u" = "25.5 g.m"

[[event]]
cycle = 6
set.rotor_contact."d1.u" = "0.5 g.m"
"""

RUN_UP = """
description = "Through the second critical speed, with contact"
Omega = "20 Hz"
settle_cycles = 1
end_time = "2 s"
inputs.rotor_contact."d1.u" = "16 g.m"

[[speed]]
time = "0.2 s"
Omega = "20 Hz"

[[speed]]
time = "1.9 s"
Omega = "28 Hz"

[record]
variables = ["*", "rolac_controller.r.*"]
every = 3
settling = true
"""

EVERYTHING = '\n[record]\nvariables = ["*", "rolac_controller.r.*"]\n'
SCENARIOS = {
    "gauss_seidel": UNBALANCE + EVERYTHING,
    "fine_jacobi": 'coupling = "jacobi"\ncommunication_step = "62.5 us"\n' + UNBALANCE + EVERYTHING,
    "profile": RUN_UP,
    "boolean_input": UNBALANCE + "\n[[event]]\ncycle = 2\nset.rolac_controller.rolac_enable = true\n" + EVERYTHING,
}
CASES = [pytest.param(name, "native", marks=pytest.mark.gate) for name in SCENARIOS]
CASES += [pytest.param("gauss_seidel", "python", marks=pytest.mark.gate), ("fine_jacobi", "python")]


@pytest.mark.parametrize(("name", "flavour"), CASES)
def test_both_loops_record_the_same(name: str, flavour: str) -> None:
    prepared = prepare_run(make_scenario(tomllib.loads(SCENARIOS[name]), "case"), options=RunOptions(flavour=flavour))
    plain, fast = (execute(prepared, RunOptions(loop=loop)).dataset for loop in ("plain", "compiled"))
    assert len(fast.data_vars) >= sum(len(interface.of("output")) for interface in prepared.interfaces.values())
    assert list(plain.variables) == list(fast.variables)
    names = list(plain.variables)
    assert [n for n in names if plain[n].values.tobytes() != fast[n].values.tobytes()] == []
    assert {**plain.attrs, "wall_s": 0} == {**fast.attrs, "wall_s": 0}
    assert fast.attrs["completed"]
    assert fast["rotor_contact.contact_state"].values.max() > 0, "a run without contact would show less"
    assert round(float(fast["time"].values[-1]) / prepared.step_size) + prepared.record_every > prepared.last
