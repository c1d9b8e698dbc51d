"""The README shows code that runs, and the theory pages figures that hold."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from code_blocks import example_of
from matplotlib.image import imread
from rig import ACTUATOR, ACTUATOR_CONSTANTS

from amb_analysis.machine.axis_capability import (
    current_amplitude,
    force_slew_rate,
    full_swing_bandwidth,
    linear_range,
    load_capacity,
)
from amb_cosim.model_constants.magnetic_bearing import axis_parameters

THEORY = Path(__file__).parents[2] / "docs" / "theory"
PAGES = [(THEORY / f"{page}.md").read_text(encoding="utf-8") for page in ("magnetic_bearing", "amplifier")]
PROSE = " ".join("\n".join(PAGES).split())


def test_the_code_of_the_readme_draws_and_prints_its_stated_output(build_fmu, run_python, tmp_path):
    shutil.copy(build_fmu(ACTUATOR, ACTUATOR_CONSTANTS), tmp_path)
    code = example_of("amb_actuator")
    program = f"import matplotlib\nmatplotlib.use('Agg')\n{code}"
    curves = "[line.get_ydata().tolist() for axes in (left, right) for line in axes.lines]"
    largest, lines = run_python(f"{program}\nresult = [float(largest), {curves}]", cwd=tmp_path)
    assert largest == pytest.approx(1700.0 - 321.0, abs=0.05)
    assert f"# {largest:.1f} N" in code
    picture = imread(tmp_path / "force.png")
    assert np.count_nonzero(picture[..., :3].min(axis=-1) < 0.9) > 5000, "something is drawn"
    assert len(lines) == 12
    for nonlinear, linear in zip(lines[0::2], lines[1::2], strict=True):
        middle = len(linear) // 2
        assert nonlinear[middle] == pytest.approx(linear[middle], abs=60.0)
        assert np.max(np.abs(nonlinear)) <= 1700.0 + 321.0 + 1e-6
        assert np.all(np.diff(nonlinear) >= -1e-9)
        assert np.all(np.diff(linear) > 0.0)


def test_figures_of_the_theory_pages_are_those_of_the_model():
    p = axis_parameters()
    result, capacity = linear_range(p), load_capacity(p, np.array([500.0 / np.sqrt(2.0)]))
    in_mm = f"{result.x[0] * 1e3:.3f} to {result.x[1] * 1e3:.3f} mm"
    assert f"{in_mm}, {result.i_c[0]:.2f} to {result.i_c[1]:.2f} A" in PROSE
    assert ", ".join(f"{rate / 1e6:.2f}" for rate in force_slew_rate(p)) + " MN/s" in PROSE
    in_hz = [full_swing_bandwidth(p, amplitude) for amplitude in (1.0, 4.43)]
    assert f"1 A up to {in_hz[0]:.0f} Hz, 4.43 A up to {in_hz[1]:.0f} Hz" in PROSE
    assert f"354 N: {capacity.up[0]:.0f} N up, {capacity.down[0]:.0f} N down" in PROSE
    assert f"`b_sat` = {p.b_sat:.4f} T" in PROSE
    assert f"above {float(current_amplitude(p, 1400.0)):.2f} A reaches the voltage limit" in PROSE
