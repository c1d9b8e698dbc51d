"""Controllers made of blocks in a file: each block against its formula, coordinates, speeds, and errors."""

import math

import numpy as np
import pytest
import tomli_w

from amb_analysis.linear.control import law_at
from amb_analysis.studies.controller_description import response
from amb_cosim import linear_controller
from amb_cosim.controllers.block_file import read_blocks
from tests.support.messages import raises_naming

T, W = 1e-4, 2.0 * math.pi * 300.0
S = 1j * W


def content(*blocks, **options):
    channel = {"from": "y", "to": "u", "blocks": list(blocks)}
    return {"inputs": ["y"], "outputs": ["u"], "sample_time": "100 us", "channel": [channel], **options}


def written(tmp_path, data):
    path = tmp_path / "controller.toml"
    path.write_text(tomli_w.dumps(data), encoding="utf-8")
    return path


def continuous(tmp_path, *blocks, omega=W):
    """The response of blocks at a frequency (rad/s), before sampling."""
    law = read_blocks(written(tmp_path, content(*blocks)), continuous=True)["K"]
    return response(law, np.array([omega]), None)[0, 0, 0]


W_OFF, LOW, HIGH = 2.0 * math.pi * 2000.0, 2.0 * math.pi * 250.0, 2.0 * math.pi * 400.0
V = 2.0 * math.pi * 200.0
FORMULAS = {
    "gain": ({"type": "gain", "gain": -3.0}, -3.0),
    "p": ({"type": "pid", "kp": "2 A/mm"}, 2e3),
    "pi": ({"type": "pid", "kp": 2e3, "ki": 1e5}, 2e3 + 1e5 / S),
    "pd": ({"type": "pid", "kp": 2e3, "kd": 5.0, "roll_off": "2 kHz"}, 2e3 + 5.0 * S / (1 + S / W_OFF)),
    "pid": (
        {"type": "pid", "kp": 2e3, "ki": 1e5, "kd": 5.0, "roll_off": 2000},
        2e3 + 1e5 / S + 5.0 * S / (1 + S / W_OFF),
    ),
    "notch": ({"type": "notch", "frequency": "200 Hz", "damping": 0.2, "depth": 0.1},
              (S**2 + 0.04 * V * S + V**2) / (S**2 + 0.4 * V * S + V**2)),
    "band_stop": ({"type": "band_stop", "low": "250 Hz", "high": "400 Hz"},
                  (S**2 + LOW * HIGH) / (S**2 + (HIGH - LOW) * S + LOW * HIGH)),
    "second_order": (
        {"type": "second_order", "frequency": "200 Hz", "damping": 0.7, "zero_frequency": "2 kHz", "zero_damping": 0.1},
        (S**2 / W_OFF**2 + 0.2 * S / W_OFF + 1) / (S**2 / V**2 + 1.4 * S / V + 1),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMULAS)
def test_block_has_the_response_of_its_formula(tmp_path, name):
    block, expected = FORMULAS[name]
    assert continuous(tmp_path, block) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize(("kind", "sign"), [("lead", 1.0), ("lag", -1.0)])
@pytest.mark.parametrize("phase", [10.0, 45.0, 80.0])
def test_lead_and_lag_have_their_phase_at_their_frequency(tmp_path, kind, sign, phase):
    block = {"type": kind, "frequency": "300 Hz", "phase": f"{phase} deg"}
    assert math.degrees(np.angle(continuous(tmp_path, block))) == pytest.approx(sign * phase)
    assert continuous(tmp_path, block, omega=1e-6) == pytest.approx(1.0)
    assert abs(continuous(tmp_path, block, omega=0.99 * W)) < abs(continuous(tmp_path, block)) or sign < 0.0


@pytest.mark.parametrize("order", range(1, 9))
def test_low_pass_is_a_butterworth_filter(tmp_path, order):
    block = {"type": "low_pass", "frequency": "200 Hz", "order": order}
    for omega in (0.1 * V, V, 3.0 * V):
        expected = 1.0 / math.sqrt(1.0 + (omega / V) ** (2 * order))
        assert abs(continuous(tmp_path, block, omega=omega)) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("hertz", [50.0, 800.0, 3000.0])
def test_sampled_prewarped_notch_is_at_its_frequency(tmp_path, hertz):
    block = {"type": "notch", "frequency": f"{hertz} Hz"}
    depths = []
    for prewarp in (True, False):
        law = linear_controller(written(tmp_path, content(block, prewarp=prewarp))).laws[0.0]
        depths.append(abs(response(law, np.array([2.0 * math.pi * hertz]), T)[0, 0, 0]))
    assert depths[0] < 1e-9
    assert depths[1] > depths[0]


def test_blocks_of_a_channel_are_in_series_and_channels_add(tmp_path):
    two = [{"type": "gain", "gain": 2.0}, {"type": "pid", "kp": 3.0, "ki": 5.0}]
    assert continuous(tmp_path, *two) == pytest.approx(6.0 + 10.0 / S)
    data = content(*two)
    data["channel"].append({"from": "y", "to": "u", "gain": -6.0})
    law = read_blocks(written(tmp_path, data), continuous=True)["K"]
    assert response(law, np.array([W]), None)[0, 0, 0] == pytest.approx(10.0 / S)


def test_law_in_modal_coordinates_couples_the_axes(tmp_path):
    data = {
        "inputs": ["a.x", "b.x", "a.y"],
        "outputs": ["a.i_x", "b.i_x", "a.i_y"],
        "sample_time": "100 us",
        "signals": {"parallel": {"a.x": 0.5, "b.x": 0.5}, "tilting": {"a.x": 0.5, "b.x": -0.5}},
        "demands": {"parallel": {"a.i_x": 1.0, "b.i_x": 1.0}, "tilting": {"a.i_x": 1.0, "b.i_x": -1.0}},
        "channel": [
            {"from": ["parallel", "tilting"], "to": ["parallel", "tilting"], "gain": 2.0},
            {"from": "tilting", "to": "tilting", "gain": 1.0},
            {"from": "a.y", "to": "a.i_x", "gain": 7.0},
        ],
    }
    D = linear_controller(written(tmp_path, data)).laws[0.0].D
    np.testing.assert_allclose(D @ [1.0, 1.0, 0.0], [2.0, 2.0, 0.0])
    np.testing.assert_allclose(D @ [1.0, -1.0, 0.0], [3.0, -3.0, 0.0])
    np.testing.assert_allclose(D @ [0.0, 0.0, 1.0], [7.0, 0.0, 0.0])


def test_gains_over_speed_are_a_table_at_all_their_speeds(tmp_path):
    data = content({"type": "pid", "kp": 1.0, "ki": 1.0})
    data["channel"][0]["gain"] = [["100 rad/s", 1.0], ["300 rad/s", 3.0]]
    data["channel"].append({"from": "y", "to": "u", "gain": [["200 rad/s", 0.0], ["300 rad/s", 10.0]]})
    laws = linear_controller(written(tmp_path, data)).laws
    assert list(laws) == pytest.approx([100.0, 200.0, 300.0])
    gains = [law.D[0, 0] / (1.0 + T / 2.0) for law in laws.values()]
    assert gains == pytest.approx([1.0, 2.0, 3.0 + 10.0 / (1.0 + T / 2.0)])


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        ({"sample_time": "1 m"}, ("sample_time",)),
        ({"method": "bilinear"}, ("'bilinear'",)),
        ({"method": "zoh", "prewarp": True}, ("prewarp", "zoh")),
        ({"inputs": []}, ("inputs",)),
        ({"inputs": ["y", "z z"]}, ("'z z'",)),
        ({"colour": "red"}, ("colour",)),
        ({"channel": []}, ("channel",)),
        ({"channel": [{"from": "z", "to": "u"}]}, ("channel 1", "from = 'z'")),
        ({"channel": [{"from": "y", "to": ["u", "u"]}]}, ("channel 1", "1 names", "'to' has 2")),
        ({"channel": [{"from": "y", "to": "u", "gain": [["2 rpm", 1.0], ["1 rpm", 1.0]]}]}, ("ascend",)),
        (
            {"channel": [{"from": "y", "to": "u", "gain": [[0, 1.0], [9000, 2.0]]}]},
            ("gain", "9000", "unit", "9000 rpm"),
        ),
        ({"signals": {"s": {"z": 1.0}}, "channel": [{"from": "s", "to": "u"}]}, ("signals.s", "'z'")),
        ({"limits": ["5 A", "1 A"]}, ("limits of u", "5", "1 A")),
        ({"delay": -1.0}, ("delay", "-1")),
    ],
)
def test_error_names_the_faulty_key_of_a_file(tmp_path, change, facts):
    path = written(tmp_path, content({"type": "gain", "gain": 1.0}) | change)
    with raises_naming(ValueError, *facts) as error:
        linear_controller(path)
    assert str(error.value).startswith(str(path))


@pytest.mark.parametrize(
    ("block", "facts"),
    [
        ({"type": "pid", "kp": 1.0, "kd": 1.0}, ("block 1", "pid", "roll_off")),
        ({"type": "noch", "frequency": "1 kHz"}, ("blocks[0].type = 'noch' is not allowed; did you mean notch?",)),
        ({"frequency": "1 kHz"}, ("blocks[0].type is missing",)),
        ({"type": "gain", "gian": 1.0}, ("blocks[0].gian; did you mean gain?",)),
        ({"type": "low_pass", "dampnig": 0.1}, ("blocks[0].dampnig; there are type, frequency, order",)),
        ({"type": "pid", "kp": "1 A"}, ("kp",)),
        ({"type": "notch", "frequency": 0.0}, ("frequency", "0.0", "> 0")),
        ({"type": "notch", "frequency": "3 m"}, ("frequency",)),
        ({"type": "notch", "frequency": 50.0, "damping": 0.0}, ("damping", "0")),
        ({"type": "lead", "frequency": 50.0, "phase": "90 deg"}, ("phase", "90 deg", "85 deg")),
        ({"type": "band_stop", "low": 50.0, "high": 40.0}, ("low", "50.0", "high")),
        ({"type": "low_pass", "frequency": 50.0, "order": 9}, ("order",)),
        ({"type": "filter", "frequency": 50.0}, ("type",)),
        ({"type": "second_order", "frequency": 50.0}, ("damping",)),
        ({"type": "second_order", "frequency": 50.0, "damping": -0.1}, ("damping", "-0.1")),
        *(
            ({"type": "notch", "damping": 0.05, "frequency": points}, facts)
            for points, facts in (
                ([["9 rad/s", "300 Hz"], ["3 rad/s", "310 Hz"]], ("block 1", "notch", "frequency", "ascend")),
                ([["0 rad/s", "300 Hz"], ["3 rad/s", "0 Hz"]], ("frequency", "0 Hz", "> 0")),
                ([["0 Hz", "300 m"]], ("block 1", "notch", "frequency")),
            )
        ),
        ({"type": "notch", "frequency": "6 kHz"}, ("6000 Hz", "prewarp")),  # above half the sample rate
    ],
)
def test_error_names_the_faulty_key_of_a_block(tmp_path, block, facts):
    with raises_naming(ValueError, *facts):
        linear_controller(written(tmp_path, content(block, prewarp=True)))


@pytest.mark.parametrize("order", [2, 4, 7, 8])
def test_blocks_in_series_have_the_product_of_their_formulas(tmp_path, order):
    """A steep low-pass between sections of lower frequencies, continuous, sampled, and as python-control has it."""
    first, last = (
        {"type": "second_order", "frequency": f, "damping": 0.9, "zero_frequency": zero, "zero_damping": 0.7}
        for f, zero in ((1280.0, 47.0), (72.0, 710.0))
    )
    blocks = first, {"type": "low_pass", "frequency": "1.7 kHz", "order": order}, last

    def product(omega):
        return pytest.approx(np.prod([continuous(tmp_path, block, omega=omega) for block in blocks]), rel=1e-9)

    assert continuous(tmp_path, *blocks) == product(W)
    expected = product(2.0 / T * math.tan(W * T / 2.0))  # Tustin's rule
    law = linear_controller(written(tmp_path, content(*blocks)))
    assert response(law.law_at(), np.array([W]), T)[0, 0, 0] == expected
    assert law.state_space()(np.exp(1j * W * T)) == expected


NOTCH = {"type": "notch", "frequency": [["0 rad/s", "300 Hz"], ["1000 rad/s", "330 Hz"]], "damping": 0.05}


def deepest(controller, speed, expected):
    """Frequency (Hz) at which the law in a controller's constants, as its FMU interpolates them, passes least."""
    law = law_at(controller.model_and_constants[1], speed)
    frequencies = expected * np.linspace(0.9, 1.1, 1401)
    z = np.exp(2j * np.pi * frequencies * T)
    passed = [abs((law.C @ np.linalg.solve(x * np.eye(len(law.A)) - law.A, law.B) + law.D)[0, 0]) for x in z]
    assert min(passed) < 0.02
    return frequencies[int(np.argmin(passed))]


def test_notch_follows_its_frequency_over_speed(tmp_path):
    """At the speeds of the table, between them, and beyond them, where the nearest applies."""
    controller = linear_controller(written(tmp_path, content(NOTCH, prewarp=True)))
    assert list(controller.laws) == [0.0, 1000.0]
    for speed, expected in {0.0: 300.0, 500.0: 315.0, 1000.0: 330.0, 2000.0: 330.0}.items():
        assert deepest(controller, speed, expected) == pytest.approx(expected, rel=2e-3)


def test_notch_between_distant_points_is_at_the_frequency_between(tmp_path):
    """One that follows the speed from 50 to 500 Hz, up and down; as many laws as its width needs."""
    for points in ([["50 Hz", "50 Hz"], ["500 Hz", "500 Hz"]], [["50 Hz", "500 Hz"], ["500 Hz", "50 Hz"]]):
        notch = {"type": "notch", "frequency": points, "damping": 0.1}
        controller = linear_controller(written(tmp_path, content(notch, prewarp=True)))
        assert len(controller.laws) < 25
        for share in (0.0, 0.07, 0.3, 0.5, 0.9, 1.0):
            speed, up = 2.0 * np.pi * (50.0 + 450.0 * share), points[0][1] == "50 Hz"
            expected = 50.0 + 450.0 * (share if up else 1.0 - share)
            assert deepest(controller, speed, expected) == pytest.approx(expected, rel=0.025 * 0.1 + 2.5e-4)


def test_state_space_of_a_table_is_that_of_its_fmu_at_every_speed(tmp_path):
    controller = linear_controller(written(tmp_path, content(NOTCH)))
    z = np.exp(2j * np.pi * 310.0 * T)
    for speed in (-1.0, 0.0, 300.0, 999.0, 1000.0, 3000.0):
        law, result = law_at(controller.model_and_constants[1], speed), controller.state_space(speed)
        expected = law.C @ np.linalg.solve(z * np.eye(len(law.A)) - law.A, law.B) + law.D
        assert result(z) == pytest.approx(expected[0, 0], rel=1e-9)
    assert controller.state_space()(z) == pytest.approx(controller.state_space(0.0)(z), rel=1e-12)


def test_gains_and_frequencies_over_speed_share_a_table(tmp_path):
    data = content(NOTCH)
    data["channel"][0]["gain"] = [["500 rad/s", 1.0], ["1500 rad/s", 3.0]]
    controller = linear_controller(written(tmp_path, data))
    assert list(controller.laws) == [0.0, 500.0, 1000.0, 1500.0]
    at_rest = [law.D + law.C @ np.linalg.solve(np.eye(2) - law.A, law.B) for law in controller.laws.values()]
    np.testing.assert_allclose(np.ravel(at_rest), [1.0, 1.0, 2.0, 3.0], rtol=1e-9)
