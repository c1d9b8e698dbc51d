"""The commands about controller files."""

import json
import tracemalloc

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.image import imread
from scipy.io import savemat

from amb_analysis.studies.controller_description import describe_controller, response
from amb_cosim import linear_controller
from amb_cosim.commands.cli import main
from amb_cosim.controllers.laws import Law
from tests.support.messages import assert_names

FILE = """
inputs = ["mb1.x", "mb2.x"]
outputs = ["mb1.i_x", "mb2.i_x"]
sample_time = "100 us"
[[channel]]
from = ["mb1.x", "mb2.x"]
to = ["mb1.i_x", "mb2.i_x"]
gain = -1
blocks = [{ type = "pid", kp = 2.34e4, kd = 36.0, roll_off = "3 kHz" }]
"""


@pytest.fixture
def command(tmp_path, monkeypatch):
    """Output of `amb-cosim controller ...` in a folder with the file `lead.toml`, or its message."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lead.toml").write_text(FILE, encoding="utf-8")

    def run(*arguments, code=0):
        done = CliRunner().invoke(main, ["controller", *arguments])
        assert done.exit_code == code, done.output
        return done.output

    return run


def test_show_prints_gains_and_phases_at_the_modes_of_a_rotor(command):
    result = json.loads(command("show", "lead.toml", "--rotor", "compressor", "--speed", "9000 rpm", "--json"))
    assert [(path["signal"], path["demand"]) for path in result["connections"]] == [
        ("mb1.x", "mb1.i_x"),
        ("mb2.x", "mb2.i_x"),
    ]
    path = result["connections"][0]
    assert path["gain_at_rest"] == pytest.approx(2.34e4, rel=1e-3)
    for hertz, phase in zip(result["modes_hz"], path["phase_at_modes_deg"], strict=True):
        s = 2j * np.pi * hertz
        exact = -(2.34e4 + 36.0 * s / (1.0 + s / (2.0 * np.pi * 3000.0)))
        assert phase == pytest.approx(np.degrees(np.angle(exact)), abs=3.0)
        assert -180.0 < phase < 0.0, "the demand damps"


@pytest.mark.parametrize(
    ("block", "gain", "text"),
    [
        ('type = "pid", kp = 2e4, ki = 3e5', None, "infinite"),
        ('type = "pid", kp = 2e4, kd = 36.0, roll_off = "3 kHz"', 2e4, "20000"),
        ('type = "pid", kp = 0.0, kd = 36.0, roll_off = "3 kHz"', 0.0, " 0 "),
    ],
)
def test_static_gain_is_that_at_rest(block, gain, text, command, tmp_path):
    (tmp_path / "law.toml").write_text(FILE[: FILE.index("blocks")] + f"blocks = [{{ {block} }}]\n", encoding="utf-8")
    path, _ = json.loads(command("show", "law.toml", "--json"))["connections"]
    assert path["gain_at_rest"] == (None if gain is None else pytest.approx(gain, rel=1e-9))
    assert text in command("show", "law.toml")


@pytest.mark.parametrize("hertz", [0.1, 397.0, 403.0])
def test_phases_are_exact_beside_a_narrow_notch_and_below_the_plot(hertz, tmp_path):
    """Integral action lags by 90 degrees at 0.1 Hz; the notch of 400 Hz changes its phase by 160 degrees in 6 Hz."""
    blocks = '{ type = "pid", kp = 2e4, ki = 3e5 }, { type = "notch", frequency = "400 Hz", damping = 0.001 }'
    head = FILE[: FILE.index("blocks")].replace("[[channel]]", "prewarp = true\n[[channel]]")
    (tmp_path / "law.toml").write_text(f"{head}blocks = [{blocks}]\n", encoding="utf-8")
    omega = 2.0 * np.pi * hertz
    path, _ = describe_controller(tmp_path / "law.toml", "0 rpm", [omega]).as_dict()["connections"]
    z, w = np.exp(1e-4j * omega), 2.0 * np.pi * 400.0
    s = 2e4 * (z - 1.0) / (z + 1.0)  # Tustin
    s_notch = w / np.tan(0.5e-4 * w) * (z - 1.0) / (z + 1.0)  # with the frequency of the notch kept
    notch = (s_notch**2 + w**2) / (s_notch**2 + 0.002 * w * s_notch + w**2)
    exact = np.degrees(np.angle(-(2e4 + 3e5 / s) * notch))
    assert path["phase_at_modes_deg"] == [pytest.approx(exact, abs=0.01)]


def test_show_includes_the_gains_of_the_demands(command, tmp_path):
    linear_controller(3.0, ["y"], ["u"], 1e-4, gains=-2.0).save(tmp_path / "law.npz")
    (path,) = json.loads(command("show", "law.npz", "--json"))["connections"]
    assert path["gain_at_rest"] == pytest.approx(6.0)


def test_show_draws_the_response_that_it_prints(command, tmp_path):
    text = command("show", "lead.toml", "-o", "bode.png")
    assert_names(text, "2 states", "0.0001 s")
    picture = imread(tmp_path / "bode.png")
    assert np.count_nonzero(picture[..., :3].min(axis=-1) < 0.9) > 5000


def test_import_samples_a_law_and_writes_named_arrays(command, tmp_path):
    savemat(tmp_path / "law.mat", {"A": [[-100.0]], "B": [[1.0]], "C": [[100.0]], "D": [[0.0]]})
    options = ("--inputs", "mb1.x", "--outputs", "mb1.i_x", "--sample-time", "100 us")
    assert command("import", "law.mat", *options).strip() == "law_controller.npz"
    result = linear_controller(tmp_path / "law_controller.npz")
    assert result.ports.signals == ("mb1.x",)
    assert result.state_space()(1.0).real == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("arguments", "facts"),
    [
        (("show", "none.toml"), ("'none.toml'",)),
        (("show", "lead.toml", "--speed", "3 m"), ("speed", "'3 m'", "rad/s")),
        (("show", "none.mat"), ("'none.mat'",)),
        (("import", "lead.csv"), ("lead.csv",)),
        (("import", "lead.toml", "--inputs", "a"), ("1 inputs",)),
        (("import", "lead.toml", "-o", "law.json"), (".npz", ".mat")),
        (("import", "lead.toml", "--sample-time", "0"), ("--sample-time",)),
    ],
)
def test_bad_input_ends_with_one_message(command, arguments, facts):
    assert_names(command(*arguments, code=2), *facts)


def test_memory_of_a_bode_plot_does_not_grow_with_its_frequencies():
    """With a matrix for each frequency a law of 600 states required 3.2 GiB."""
    n, points = 100, 400
    law = Law(np.diag(np.linspace(0.1, 0.9, n)), np.ones((n, 1)), np.ones((1, n)), np.zeros((1, 1)))
    tracemalloc.start()
    result = response(law, np.linspace(1.0, 3e4, points), 1e-4)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert result.shape == (points, 1, 1)
    assert peak < 10 * 16 * n**2  # bytes: ten complex matrices
