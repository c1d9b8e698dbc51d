"""The live rig with a linear controller whose gains change by hand during a run."""

from pathlib import Path

import numpy as np
import pytest

import amb_cosim

LEAD = Path(__file__).parents[2] / "examples" / "controllers" / "lead_notches.toml"
AXES = [f"rotor_contact.{bearing}.{axis}" for bearing in ("mb1", "mb2") for axis in "xy"]
GAIN = "rolac_controller.mb1.i_x.gain"
CHANGE, END = 0.02, 0.04  # s
SCENARIO = f"""
base = "compressor_levitated"
remove = ["event", "end_cycle"]
fmu.rolac_controller = "{LEAD}"
settle_cycles = 0
end_time = "{END} s"
inputs.rotor_contact."impeller3.u" = "3 g.m"
"""
EVENT = f"""
[[event]]
time = "{CHANGE} s"
set.rolac_controller."mb1.i_x.gain" = 1.3
"""

pytestmark = pytest.mark.slow


def test_gain_changed_by_hand_equals_that_changed_by_an_event(session, tmp_path):
    """In WebAssembly and native the displacements are the same before, to the rounding of another processor."""
    for name, text in (("lead_by_hand", SCENARIO), ("lead_by_event", SCENARIO + EVENT)):
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
    native = amb_cosim.run(tmp_path / "lead_by_event.toml", progress=False)
    requests = [{"type": "run", "to": CHANGE}, {"type": "set", "values": {GAIN: 1.3}}, {"type": "run", "to": END}]
    answers = session(str(tmp_path / "lead_by_hand.toml"), AXES, *requests)
    np.testing.assert_array_equal(answers.rows[:, 0], native.signals["time"].values)
    for axis in AXES:
        expected = native.signals[axis].values
        assert np.abs(expected).max() > 1e-6
        np.testing.assert_allclose(answers.column(axis), expected, rtol=0.0, atol=1e-9 * 0.25e-3)
    unchanged = amb_cosim.run(tmp_path / "lead_by_hand.toml", progress=False).signals[AXES[0]].values
    assert np.abs(answers.column(AXES[0]) - unchanged).max() > 1e-8
