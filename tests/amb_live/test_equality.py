"""The rig in node is the run of the orchestrator: the same machine code for another processor."""

import numpy as np
import pytest

import amb_cosim

pytestmark = pytest.mark.slow  # the engine is compiled as WebAssembly first

SITES = ("rb1", "rb2", "eb1", "eb2")
DISPLACEMENTS = [*(f"rotor_contact.mb{k}.{axis}" for k in (1, 2) for axis in "xy")]
DISPLACEMENTS += [f"rotor_contact.s{k}" for k in range(1, 9)]
OTHERS = [f"rotor_contact.{site}.{name}" for site in SITES for name in ("mode", "f_n")]
OTHERS += ["rotor_contact.contact_state"]
OTHERS += ["rotor_contact.theta", "rolac_controller.mb1.i_x", "amb_actuator.mb2.f_y", "rolac_controller.rolac_status"]
WATCHED = DISPLACEMENTS + OTHERS
CLEARANCE = 0.75e-3  # m, of the retainers


@pytest.mark.host("node", "node", platform="WebAssembly", fmus="three of a scenario", what="this master's run")
@pytest.mark.parametrize("name", ["fig4_9", "fig5_6", "drop"])
def test_a_scenario_in_node_agrees_with_the_orchestrator(name, session, record_property, capsys):
    native = amb_cosim.run(name, progress=False)
    dataset = native.dataset
    end = float(dataset["time"][-1])
    answers = session(name, WATCHED, {"type": "run", "to": end})
    (ended,) = answers.of("ended")
    assert (ended["reason"], ended["time"]) == (native.outcome.status, native.outcome.time)
    np.testing.assert_array_equal(answers.rows[:, 0], dataset["time"])
    for site in SITES:
        mode = f"rotor_contact.{site}.mode"
        np.testing.assert_array_equal(answers.column(mode), dataset[mode], err_msg=mode)
    touching = dataset["rotor_contact.contact_state"].values != 0
    first = int(np.argmax(touching)) if touching.any() else len(touching)
    apart = np.max([np.abs(answers.column(signal) - dataset[signal].values) for signal in DISPLACEMENTS], axis=0)
    before, largest = apart[:first].max(), apart.max()
    record_property("largest_difference_before_contact_m", float(before))
    record_property("largest_difference_m", float(largest))
    with capsys.disabled():
        print(f"\n{name}: displacements differ by {before:.1e} m before the first contact, by {largest:.1e} m in all")
    assert touching.any()
    assert before < 1e-9 * CLEARANCE
    assert largest < 1e-6 * CLEARANCE
