"""Controllers of first designs: zones of sensitivity, damping, and the reasons of those that miss a target.

`blower.toml` is the drawing of a 250 kW blower for 24,000 rpm, whose free modes a Timoshenko model confirms.
"""

import math
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis.linear.loop import Loop, LoopPoles
from amb_analysis.machine.machine import Machine
from amb_analysis.studies.sensitivity_curves import peaks_of, sensitivity_bands
from amb_assessment.assessment.engine.assess import assess
from amb_assessment.assessment.engine.findings import Judgement
from amb_assessment.first_design import design
from amb_assessment.first_design.design import first_design
from amb_assessment.first_design.files import new_machine
from amb_assessment.first_design.levitation import Levitation, Pid, growth_in_runs, levitation_of, wanted_ratios
from amb_assessment.first_design.loop_search import LoopSearch, Peak
from amb_cosim.results.loop_stability import LoopStability
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from rotor_analysis.packaged_rotors import rotor_path
from tests.support.messages import assert_names

RPM = math.pi / 30.0
HERE = Path(__file__).parent
PAGE = HERE.parents[2] / "docs" / "tutorials" / "own_machine.md"


def drawing_of_the_page():
    text = PAGE.read_text(encoding="utf-8")
    begin = text.index("# drawing.toml")
    return text[begin : text.index("```", begin)]


def supports_of(places):
    """Bearings, sensors and retainers of the page's rotor at (z of bearing, z of sensor, z of retainer)."""
    text = ""
    for name, (bearing, sensor, retainer) in zip(("left", "right"), places, strict=True):
        text += f'[[bearings]]\nname = "{name}"\nz = {bearing}\n[[sensors]]\nname = "probe_{name}"\nz = {sensor}\n'
        text += f'[[sites]]\nname = "catcher_{name}"\nz = {retainer}\nclearance = 0.25e-3\nbearing = "{name}"\n'
    return text


ACROSS = ((0.216, 0.33, 0.156), (0.984, 0.87, 1.044))  # sensors beyond the node of the first bending mode at the left


def expander(damping):
    """The packaged expander with two overhung wheels, with its own or with the assumed damping."""
    text = rotor_path("turbo_expander").read_text(encoding="utf-8")
    return text if damping else text.replace("[damping]\nmodal = 0.001\nrotating = 1.0\n", "")


def loop_of(folder, pid=None):
    values = {} if pid is None else {f"rolac_controller.{name}": value for name, value in pid.parameters.items()}
    return Machine(prepare_run(load_scenario(str(folder / "levitation.toml")).machine(), values)).loop


@pytest.fixture(scope="module")
def page_machine(tmp_path_factory):
    return new_machine(tmp_path_factory.mktemp("design") / "page", drawing_of_the_page(), 12000.0 * RPM)


def test_machine_of_the_page_reaches_zone_a_with_full_damping(page_machine):
    loop = page_machine.design.loop
    assert loop.zone == "A"
    assert loop.peak.value < 3.0
    assert loop.in_range > 0.1
    assert page_machine.design.shortfalls == ()


@pytest.mark.parametrize(
    ("slow", "facts"),
    [
        (Levitation(0.2, 0.1, 0.01, 1.0, 1.0, Peak(3.4), Peak(1.0), (0.1, 0.02, 0.002)), ("3.4", "zone B", "3")),
        (Levitation(0.2, 0.01, 0.01, 1.0, 1.0, Peak(4.4), Peak(1.0), (0.1, 0.02, 0.002)), ("zone C", "0.01", "0.02")),
        (Levitation(-0.1, -0.1, -0.1, 1.0, 9.0, Peak(9.0), Peak(9.0), (0.1, 0.02, 0.002), "a drift"), ("a drift",)),
    ],
)
def test_a_rejected_sample_time_is_named_with_the_targets_that_it_misses(monkeypatch, slow, facts):
    loops = iter((slow, Levitation(0.2, 0.1, 0.01, 1.0, 1.0, Peak(2.5), Peak(1.0), (0.1, 0.02, 0.002))))
    designer = SimpleNamespace(
        best=lambda: Pid({}, {}, 1e-5), wanted=(), machine=lambda pid: SimpleNamespace(loop=0, run_loop=0)
    )
    for name, result in (
        ("operating_points", lambda sizes: {}),
        ("Designer", lambda *_: designer),
        ("levitation_of", lambda *_: next(loops)),
        ("growth_in_runs", lambda *_: ""),
        ("shortfalls", lambda *_: ()),
        ("high_voltage", lambda *_: ()),
    ):
        monkeypatch.setattr(design, name, result)
    made = first_design(SimpleNamespace(speed=100.0), lambda _: None, None, sample_times=(8e-5, 4e-5))
    (other,) = made.rejected
    assert (made.sample_time, other.sample_time) == (4e-5, 8e-5)
    assert_names(" ".join(other.shortfalls), *facts)


def test_sensitivity_of_the_design_is_that_of_the_closed_loop(page_machine):
    """(1 - K G)^-1 from plant and law apart, and the state-space model of the whole loop; |S| = K_s/K_b at rest."""
    folder, pid = page_machine.folder, page_machine.design.pid
    loop = loop_of(folder)
    Omega = 12000.0 * RPM
    search = LoopSearch(loop, [Omega])
    low, high = search.peaks(search.law(pid.parameters))
    system = Loop(loop.linear_components.at(Omega)).sensitivity()
    for peak, band in zip((low, high), sensitivity_bands(system), strict=True):
        assert peak.value == pytest.approx(max(value for value, _ in peaks_of(*band)), rel=1e-3)


@pytest.mark.slow
def test_a_node_between_sensor_and_magnet_is_a_shortfall(tmp_path):
    """Sensors beyond the node of the first bending mode: its shape has another sign there than at the magnet."""
    text = drawing_of_the_page() + supports_of(ACROSS)
    made = new_machine(tmp_path / "across", text, 12000.0 * RPM)
    (reason,) = [lack for lack in made.design.shortfalls if "node" in lack]
    assert_names(reason, "bending mode 1", "367 Hz", "left", "probe_left")
    result = assess(made.folder / "machine.toml", only=["free_modes"])
    findings = [finding for part in result.parts for finding in part.findings]
    first = next(finding for finding in findings if finding.measured.quantity == "mode_reach")
    assert first.measured.value < 0.0
    assert first.verdict == Judgement.FAILED


@pytest.mark.slow
def test_blower_reaches_zone_a_and_names_the_mode_it_cannot_damp(tmp_path):
    text = (HERE / "blower.toml").read_text(encoding="utf-8")
    made = new_machine(tmp_path / "blower", text, 24000.0 * RPM)
    loop = made.design.loop
    assert loop.zone == "A"
    assert loop.peak_beyond.value < 4.0
    assert min(loop.ratios) > 0.0
    assert_names(" ".join(made.design.shortfalls), "bending mode 1", "476 Hz", "probe_a", "probe_b")


@pytest.mark.slow
def test_expander_at_42000_rpm_reaches_zone_a_with_assumed_damping(tmp_path):
    made = new_machine(tmp_path / "assumed", expander(damping=False), 42000.0 * RPM)
    assert made.assumed == ("damping",)
    assert made.design.loop.zone == "A"


@pytest.mark.slow
def test_low_damping_of_the_expander_at_42000_rpm_is_a_shortfall(tmp_path):
    """A tenth of a per cent of damping in its high modes: the design levitates, and the cause of its zone is named."""
    made = new_machine(tmp_path / "bare", expander(damping=True), 42000.0 * RPM)
    assert made.design.loop.is_stable
    assert_names(" ".join(made.design.shortfalls), "turbo_expander", "damping ratios from 0.001")


@pytest.mark.parametrize(("factor", "motion"), [(-0.3, "drift"), (1.0, "")])
def test_a_bearing_of_negative_stiffness_drifts_away(page_machine, factor, motion):
    """A closed bearing of negative stiffness: its pole is real, so no vibration has it."""
    pid, speed = page_machine.design.pid, 12000.0 * RPM
    changed = Pid({name: factor * k for name, k in pid.k_b.items()}, pid.c_b, pid.derivative_time)
    wanted = wanted_ratios(page_machine.sizes.rotor)
    loop = levitation_of(loop_of(page_machine.folder, changed), speed, changed, wanted)
    assert loop.is_stable == (not motion)
    assert motion in loop.motion
    assert math.isinf(loop.peak.value) == bool(motion)
    assert motion in growth_in_runs(loop_of(page_machine.folder, changed), speed)
    assert bool(growth_in_runs(loop_of(page_machine.folder, changed), speed)) == bool(motion)


class LoopOfOneVibration:
    """A vibration of 500 rad/s: zeta = 0.3 - 0.22/(1 + ((Omega - 610)/200)^2), of which 0.08 is the least."""

    def poles(self, Omega):
        zeta = 0.3 - 0.22 / (1.0 + ((Omega - 610.0) / 200.0) ** 2)
        s = 500.0 * complex(-zeta, math.sqrt(1.0 - zeta**2))
        pair = np.array([s, s.conjugate()])
        stability = LoopStability(math.exp(1e-4 * s.real), s.real, s.imag, speed=Omega)
        return LoopPoles(np.exp(1e-4 * pair), pair, np.array([[1.0, 1.0], [-1.0j, 1.0j]]), stability)


class PeaksOverSpeed:
    """|S| = 2 + 0.8/(1 + ((Omega - 620)/200)^2) up to 2 kHz, 3 - ((Omega - 300)/1000)^2 above."""

    def __init__(self, loop, speeds):
        (self.Omega,) = speeds

    def law(self, gains):
        return gains

    def peaks(self, law):
        low = 2.0 + 0.8 / (1.0 + ((self.Omega - 620.0) / 200.0) ** 2)
        return Peak(low, "left.x", 100.0, self.Omega), Peak(3.0 - ((self.Omega - 300.0) / 1000.0) ** 2)


def test_values_of_a_design_are_the_worst_between_grid_speeds(monkeypatch):
    """None of 0, 400, 800, 1000 and 1050 rad/s is within 190 rad/s of the worst."""
    monkeypatch.setattr("amb_assessment.first_design.loop_search.LoopSearch", PeaksOverSpeed)
    loop = levitation_of(LoopOfOneVibration(), 1000.0, Pid({}, {}, 1e-5), (0.1, 0.02, 0.002))
    assert (loop.in_range, loop.beyond) == (pytest.approx(0.08, rel=1e-3), 1.0)
    assert loop.speed == pytest.approx(610.0, abs=10.0)
    assert (loop.peak.value, loop.peak.axis) == (pytest.approx(2.8, rel=1e-3), "left.x")
    assert loop.peak_beyond.value == pytest.approx(3.0, rel=1e-3)
    assert loop.is_stable


def test_wanted_damping_is_at_most_half_of_the_rotors_damping(page_machine):
    assert wanted_ratios(page_machine.sizes.rotor) == (0.1, 0.02, pytest.approx(0.0015))
