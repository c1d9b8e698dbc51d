"""Arguments of `linear_controller` apply to a law in a file as to the object, or are refused; discretisations."""

import control
import numpy as np
import pytest

import amb_cosim
from tests.support.messages import assert_names, raises_naming

T = 1e-4
LEAD = -control.tf([36.0 + 2.34e4 * 5e-5, 2.34e4], [5e-5, 1.0])
ENDS = (["mb1.x"], ["mb1.i_x"])
BLOCKS = """
inputs = ["mb1.x"]
outputs = ["mb1.i_x"]
sample_time = 1e-4
delay = 0.5
limits = [-1.0, 1.0]

[[channel]]
from = "mb1.x"
to = "mb1.i_x"
gain = -20000.0
"""


@pytest.mark.parametrize(
    "options",
    [
        {"gains": 2.0, "limits": (-3.0, 3.0), "delay": 1.5},
        {"offsets": 0.25},
        {"delay": 0.0},
        {"slow_time": 0.02},
        {"outputs": ["mb2.i_x"], "gains": [0.5]},
    ],
)
@pytest.mark.parametrize("suffix", [".npz", ".mat"])
def test_arguments_apply_to_a_file_of_arrays_as_to_the_object(tmp_path, options, suffix):
    file = amb_cosim.linear_controller(LEAD, *ENDS, sample_time=T).save(tmp_path / f"law{suffix}")
    of_file = amb_cosim.linear_controller(file, **options)
    of_object = amb_cosim.linear_controller(LEAD, **{"inputs": ENDS[0], "outputs": ENDS[1]} | options, sample_time=T)
    assert dict(of_file.starts) == dict(of_object.starts)
    assert (of_file.slow_time, of_file.ports) == (of_object.slow_time, of_object.ports)
    assert of_file.state_space()(1.0) == of_object.state_space()(1.0)


def test_arguments_replace_values_of_a_controller_file_and_others_stay(tmp_path):
    (tmp_path / "law.toml").write_text(BLOCKS)
    starts = amb_cosim.linear_controller(tmp_path / "law.toml", limits=(-3.0, 2.0)).starts
    assert (starts["mb1.i_x.lower"], starts["mb1.i_x.upper"], starts["delay"]) == (-3.0, 2.0, 0.5)
    controller = amb_cosim.linear_controller(tmp_path / "law.toml", gains=3.0)
    assert (controller.state_space()(1.0).real, controller.starts["mb1.i_x.upper"]) == (-60000.0, 1.0)


def test_saved_settings_stay_unless_an_argument_replaces_them(tmp_path):
    settings = {"gains": 2.0, "limits": (-3.0, 3.0), "delay": 1.5}
    file = amb_cosim.linear_controller(LEAD, *ENDS, sample_time=T, **settings).save(tmp_path / "law.npz")
    starts = amb_cosim.linear_controller(file, delay=0.5).starts
    assert (starts["mb1.i_x.gain"], starts["mb1.i_x.upper"], starts["delay"]) == (2.0, 3.0, 0.5)


def test_a_continuous_law_in_a_file_is_sampled_by_the_method(tmp_path):
    law = {"A": [[-100.0]], "B": [[1.0]], "C": [[100.0]], "D": [[0.0]]}
    np.savez(tmp_path / "law.npz", **law, inputs=ENDS[0], outputs=ENDS[1])
    controller = amb_cosim.linear_controller(tmp_path / "law.npz", sample_time=1e-3, method="zoh")
    assert controller.state_space().A[0, 0] == pytest.approx(np.exp(-0.1), rel=1e-12)


@pytest.mark.parametrize("name", ["law.npz", "law.toml"])
@pytest.mark.parametrize("option", [{"method": "zoh"}, {"prewarp": 100.0}, {"sampled_arrays": True}])
def test_a_discretisation_of_a_sampled_law_is_refused(tmp_path, name, option):
    (tmp_path / "law.toml").write_text(BLOCKS)
    amb_cosim.linear_controller(LEAD, *ENDS, sample_time=T).save(tmp_path / "law.npz")
    with raises_naming(ValueError, name, *option):
        amb_cosim.linear_controller(tmp_path / name, **option)
    if "sampled_arrays" not in option:
        with raises_naming(ValueError, *option):
            amb_cosim.linear_controller(control.ss(control.c2d(LEAD, T, "tustin")), *ENDS, **option)


@pytest.mark.parametrize(
    ("law", "order", "coefficient"),
    [
        (control.tf([100.0], [1.0, 100.0]), 0, 1.0),
        (control.tf([2.0, 50.0], [1.0, 0.0]), -1, 50.0),  # PI
        (control.tf([1.0, 0.0], [1.0, 100.0]), 1, 0.01),
        (control.tf([3.0, 6.0], [1.0, 0.0, 0.0]), -2, 6.0),
    ],
)
def test_the_matched_method_keeps_static_gain_and_rate_of_integration(law, order, coefficient):
    """K(s) -> coefficient s^order as s -> 0; here at s T = 1e-3, of which the error is a few times s T."""
    step = 1e-3
    result = amb_cosim.linear_controller(law, *ENDS, sample_time=step, method="matched").state_space()
    s = 1.0
    assert result(np.exp(s * step)).real == pytest.approx(law(s).real, rel=3e-3)
    assert coefficient * s**order == pytest.approx(law(s).real, rel=1.0)
    expected = np.sort_complex(np.exp(law.poles() * step))
    np.testing.assert_allclose(np.sort_complex(result.poles()), expected, atol=1e-7)


def test_quantities_of_a_controller_may_have_units_and_its_sample_time_is_dt():
    law = control.ss([[-1000.0]], [[1.0]], [[-2e7]], [[0.0]])
    names = {"inputs": "left.x", "outputs": "left.i_x"}
    numbers = {"sample_time": 1e-4, "offsets": 0.5, "limits": (-4.0, 4.0), "delay": 0.25, "slow_time": 0.2}
    texts = {
        "sample_time": "100 us",
        "offsets": ["500 mA"],
        "limits": [("-4 A", "4000 mA")],
        "delay": "25 us",
        "slow_time": "200 ms",
    }
    stated, written = (
        amb_cosim.linear_controller(law, **names, **options, prewarp=speed)
        for options, speed in ((numbers, 200 * np.pi), (texts, "100 Hz"))
    )
    assert stated.dt == written.dt == 1e-4
    assert written.starts == pytest.approx(stated.starts)
    np.testing.assert_allclose(written.law_at().A, stated.law_at().A, rtol=1e-14)
    assert written.slow_time == stated.slow_time == 0.2
    table = amb_cosim.linear_controller({"0 rpm": law, "9000 rpm": 2 * law}, **names, sample_time="100 us")
    assert list(table.laws) == pytest.approx([0.0, 300 * np.pi])


def test_a_controller_is_described_by_its_size_and_told_apart_from_others():
    one, other = (
        amb_cosim.linear_controller(control.ss(-1000.0, 1.0, k, 0.0), "left.x", "left.i_x", "100 us")
        for k in (-2e7, -3e7)
    )
    assert_names(repr(one), "signals: 1", "demands: 1", "states: 1", "0.0001 s")
    assert repr(one) != repr(other)
