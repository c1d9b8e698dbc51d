"""Verdicts on the stability of machines: every pole counts, at every speed up to the trip speed."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from amb_analysis.machine.axis_capability import current_amplitude
from amb_analysis.machine.coupled import coupled_loop
from amb_analysis.studies import figure, poles
from amb_analysis.studies.loop_vibrations import Vibrations
from amb_assessment.assessment.analyses import closed_loop, cross_coupling, robustness
from amb_assessment.assessment.engine.assess import ANALYSES, Needs, assess
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_assessment.assessment.physics.stability import least_stable
from amb_assessment.assessment.physics.stages import real_coefficients, table_notes
from amb_cosim.commands.cli import main
from amb_cosim.results.loop_stability import LoopStability
from rotor_analysis.packaged_rotors import rotor_path
from tests.support.messages import assert_names, raises_naming

BLOWER = Path(__file__).parent / "blower"  # a 250 kW blower designed for this project
ONE_AXIS_WEAK = BLOWER / "one_axis_weak.toml"
LINEAR = ["closed_loop", "cross_coupling"]
OF_LEVITATION = {name for name, part in ANALYSES.items() if part.needs >= Needs.STABLE_LOOP}


def with_law(machine, law: Path):
    return load_machine(machine).model_copy(update={"controller": str(law)})


def verdicts(result):
    return {item.criterion.key: item for item in result.findings if item.criterion is not None}


@pytest.fixture(scope="module")
def weak():
    return assess(with_law(BLOWER / "machine.toml", ONE_AXIS_WEAK), only=[*LINEAR, *OF_LEVITATION])


def test_a_machine_that_levitates_is_stable():
    found = verdicts(assess(BLOWER / "machine.toml", only=LINEAR))
    assert {item.verdict for item in found.values()} == {Judgement.MET}
    assert found["stable"].measured.value == pytest.approx(0.9989, abs=1e-4)
    assert found["stable"].measured.facts["growth_rate"] == pytest.approx(-22.0, abs=0.5)


def test_half_the_gain_in_one_axis_makes_the_rotor_drift(weak):
    """The pole is real: |z| = 1.0029, and grows by 58 1/s."""
    found = verdicts(weak)
    stable = found["stable"]
    assert (stable.verdict, stable.measured.facts["frequency"]) == (Judgement.FAILED, 0.0)
    assert stable.measured.value == pytest.approx(1.0029, abs=1e-4)
    assert stable.measured.facts["growth_rate"] == pytest.approx(58.0, abs=0.5)
    assert_names(stable.measured.where, "drift", "amb_a.x")
    assert found["level_one_ratio"].measured.value == 0.0


def test_parts_that_need_levitation_stay_open_for_a_falling_rotor(weak):
    assert set(weak.unanswered) == OF_LEVITATION
    (reason,) = set(weak.unanswered.values())
    assert_names(reason, "not stable", "drift", "amb_a.x")
    assert not [item for part in weak.parts if part.key in OF_LEVITATION for item in part.findings]
    keys = {"level_one_decrement", "level_one_ratio", "level_two_decrement"}
    assert weak.unevaluated == dict.fromkeys(keys, reason.partition("; ")[0])


def test_an_unstable_machine_ends_the_command_with_exit_code_1(tmp_path):
    pytest.importorskip("plotly")
    text = (BLOWER / "machine.toml").read_text(encoding="utf-8")
    text = text.replace('"levitation.toml"', f'"{BLOWER.as_posix()}/levitation.toml"')
    (tmp_path / "machine.toml").write_text(
        text.replace('"controller.toml"', f'"{ONE_AXIS_WEAK.as_posix()}"'), encoding="utf-8"
    )
    values = ["assess", str(tmp_path / "machine.toml"), "--no-pdf", "-o", str(tmp_path / "page")]
    ended = CliRunner().invoke(main, [*values, "--only", "closed_loop"])
    assert ended.exit_code == 1
    assert_names(ended.output, "machine is not stable", "drift", "amb_a.x")
    first, *sentences = ended.stdout.splitlines()
    data = json.loads((tmp_path / "page" / "assessment.json").read_text(encoding="utf-8"))
    judged = [item for item in data["parts"]["closed_loop"]["findings"] if "criterion" in item]
    keys = {item["criterion"]["key"] for item in judged}
    failed = len({item["criterion"]["key"] for item in judged if item["verdict"] == "failed"})
    assert_names(first, f"{failed} of {len(keys)}", f"{len(keys) - failed} unanswered", "closed_loop")
    assert_names(sentences[0], "unstable", "amb_a.x", "drift")
    assert sum(line.startswith("  ") for line in sentences) == failed
    ended = CliRunner().invoke(main, [*values, "--only", "envelope", "--only", "unbalance"])
    assert ended.exit_code == 1
    assert_names(ended.output, "unbalance", "envelope", "unanswered", "loop is not stable")
    ended = CliRunner().invoke(main, [*values, "--only", "cross_coupling"])
    assert ended.exit_code == 1
    assert_names(ended.output, "level_one_decrement", "level_one_ratio", "unanswered", "drift", "amb_a.x")


def test_poles_over_speed_report_a_drift_with_axis_and_rate():
    result = poles(BLOWER / "levitation.toml", controller=ONE_AXIS_WEAK, count=4)
    assert len(result.unstable) == len(result.speeds)
    assert result.spectral_radii == pytest.approx(1.0029, abs=1e-4)
    assert result.growth_rates == pytest.approx(58.0, abs=1.0)
    assert_names(" ".join(map(str, result.text())), "36 to", "36000 rpm", "drift", "amb_a.x", "58.2 1/s")
    legends = [legend for part in figure(result).subfigs for legend in part.legends]
    assert "not stable" in [entry.get_text() for legend in legends for entry in legend.texts]


def found_in(result, subject):
    """Return the findings of an analysis by the key of their criterion."""
    findings = judge(result.quantities, load_criteria(), subject.facts)
    return {item.criterion.key: item for item in findings if item.criterion}


@pytest.fixture
def expander(tmp_path):
    """The packaged expander with a text of its rotor file replaced."""

    def changed(old: str, new: str):
        text = rotor_path("turbo_expander").read_text(encoding="utf-8")
        assert old in text
        (tmp_path / "rotor.toml").write_text(text.replace(old, new), encoding="utf-8")
        return load_machine("turbo_expander").model_copy(update={"rotor": str(tmp_path / "rotor.toml")})

    return changed


def test_an_unstable_corner_misses_its_sensitivity_and_stability(expander, monkeypatch):
    """With less damping a mode at 4.6 kHz grows, beyond the frequency up to which the file assesses decrements."""
    all_corners = robustness.variations
    monkeypatch.setattr(robustness, "variations", lambda given: dict([*all_corners(given).items()][::4]))
    subject = assessed_machine_of(expander("modal = 0.001\n", "modal = 0.0008\n"))
    result = robustness.result_of(subject)
    found, rows = found_in(result, subject), result.tables[0].rows
    assert found["stable_with_tolerances"].verdict is Judgement.FAILED
    assert found["stable_with_tolerances"].measured.value > 1.0001
    assert found["sensitivity_with_tolerances"].verdict is Judgement.FAILED
    assert found["sensitivity_with_tolerances"].measured.shown == "without bound"
    assert sum("vibration of 4" in motion and peak == "not stable" for *_, motion, _, peak in rows) >= 2
    for name, radius, _, _, peak in rows:
        assert (float(radius) > 1.0) == (peak == "not stable"), name


@pytest.mark.parametrize(
    ("component", "name", "value"),
    [
        ("amb_actuator", "amb_a.amplifier_off_x", "true"),
        ("amb_actuator", "amb_b.coil_loss_upper_y", "1.0"),
        ("rolac_controller", "probe_a.x.fault_dead", "true"),
    ],
)
def test_a_machine_that_begins_with_a_fault_is_refused(component, name, value, tmp_path):
    """Linear models have no faults: without magnets a rotor would be called stable."""
    shutil.copytree(BLOWER, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "levitation.toml"
    text = path.read_text(encoding="utf-8").replace("rolac_enable = false", "").replace("[inputs.rolac_controller]", "")
    path.write_text(f'{text}\n[inputs.{component}]\n"{name}" = {value}\n', encoding="utf-8")
    with raises_naming(ValueError, "fault", f"{component}.{name}"):
        assess(tmp_path / "machine.toml", only=["closed_loop"])


SWIRL = 1500.0  # rad/s, passed in every run-up
SEAL = f"""[[seals]]
name = "swirl"
z = 0.26
at_speed = [
  {{ speed = 0.0, stiffness = 0.0 }},
  {{ speed = '{SWIRL - 300.0} rad/s', stiffness = 0.0 }},
  {{ speed = '{SWIRL} rad/s', stiffness = [[0.0, 1e7], [-1e7, 0.0]] }},
  {{ speed = '{SWIRL + 300.0} rad/s', stiffness = 0.0 }},
]

# The steel of the shaft"""


def test_speeds_below_the_operating_range_are_judged(expander):
    """A seal drives forward whirl around one speed below the operating range."""
    file = expander("# The steel of the shaft", SEAL)
    machine = assessed_machine_of(file)
    loop = coupled_loop(machine, real_coefficients(machine))
    for Omega in (file.speed.lowest, file.speed.highest, file.speed.tripping):
        assert loop.poles(Omega).stability.is_stable
    worst = least_stable(machine)
    assert not worst.is_stable
    assert worst.speed == pytest.approx(SWIRL, rel=0.01)
    found = found_in(closed_loop.result_of(machine), machine)["stable"]
    assert (found.verdict, found.measured.value) == (Judgement.FAILED, pytest.approx(worst.radius, abs=1e-9))


def test_a_low_gain_between_two_entries_of_a_table_is_judged(tmp_path):
    """A law with 0.3 of its gain only at 5,100 rpm, between two speeds of the grid, loses the rotor there."""
    speeds = '[["0 rpm", -1.0], ["5000 rpm", -1.0], ["5100 rpm", -0.3], ["5200 rpm", -1.0], ["30000 rpm", -1.0]]'
    text = (BLOWER / "controller.toml").read_text(encoding="utf-8")
    (tmp_path / "scheduled.toml").write_text(text.replace("gain = -1\n", f"gain = {speeds}\n", 1), encoding="utf-8")
    found = assess(with_law(BLOWER / "machine.toml", tmp_path / "scheduled.toml"), only=["closed_loop", "envelope"])
    assert verdicts(found)["stable"].verdict is Judgement.FAILED
    assert verdicts(found)["stable"].measured.facts["N"] == pytest.approx(5100.0, abs=60.0)
    assert set(found.unanswered) == {"envelope"}


def test_tables_that_end_before_the_trip_speed_are_named(tmp_path):
    """A stage up to 2000 rad/s and gains up to 20,000 rpm (2094 rad/s), judged up to 26,400 rpm (2765 rad/s)."""
    text = (BLOWER / "controller.toml").read_text(encoding="utf-8")
    gains = '[["0 rpm", -1.0], ["20000 rpm", -1.0]]'
    (tmp_path / "scheduled.toml").write_text(text.replace("gain = -1\n", f"gain = {gains}\n", 1), encoding="utf-8")
    file = load_machine(BLOWER / "machine.toml")
    (stage,) = file.stages
    rows = [{"speed": Omega, "stiffness": 1e5} for Omega in (0.0, 2000.0)]
    tabled = type(stage).model_validate(stage.model_dump(mode="json", exclude_none=True) | {"real": rows})
    changed = {"stages": (tabled,), "controller": str(tmp_path / "scheduled.toml")}
    first, second = table_notes(assessed_machine_of(file.model_copy(update=changed)), file.speed.tripping)
    assert_names(first, "impeller", "19099 rpm", "nearest speed")
    assert_names(second, "controller", "20000 rpm", "nearest speed")
    assert table_notes(assessed_machine_of(file), file.speed.tripping) == []


def test_the_least_stable_speed_is_found_between_those_of_a_grid(expander):
    machine = assessed_machine_of(expander("# The steel of the shaft", SEAL))
    loop = coupled_loop(machine, real_coefficients(machine))
    worst = loop.least_stable(np.linspace(0.0, 4400.0, 31))
    radii = {Omega: loop.poles(float(Omega)).stability.radius for Omega in np.linspace(1400.0, 1800.0, 41)}
    assert worst.radius - 1.0 == pytest.approx(max(radii.values()) - 1.0, rel=2e-3)
    assert worst.speed == pytest.approx(max(radii, key=lambda Omega: radii[Omega]), abs=10.0)


def test_a_machine_turned_by_180_degrees_has_the_same_poles_and_demands():
    """Gravity along the other diagonal loads the other coil pairs, which then have the bias and the static current."""
    file = load_machine(BLOWER / "machine.toml")
    first, turned = (
        assessed_machine_of(file.model_copy(update={"gravity_angle": f"{angle} deg"})) for angle in (225, 45)
    )
    Omega = file.speed.highest
    radii = [coupled_loop(item, real_coefficients(item)).poles(Omega).stability.radius for item in (first, turned)]
    assert radii[0] == pytest.approx(radii[1], rel=1e-9)
    for bearing, axis in first.loop.axes:
        limits = [current_amplitude(item.axis(bearing, axis), np.array([400.0, 2000.0])) for item in (first, turned)]
        assert limits[0] == pytest.approx(limits[1])


def test_threshold_of_cross_coupling_is_the_start_of_a_narrow_range(monkeypatch):
    """sigma = 12/(1 + ((q - 3.4)/0.3)^2) - 10 is positive from 3.4 - 0.3/5^(1/2) to 3.4 + 0.3/5^(1/2)."""

    def vibrating(factor, speed):
        growth = 12.0 / (1.0 + ((factor - 3.4) / 0.3) ** 2) - 10.0
        return Vibrations(np.array([growth + 300.0j]), np.ones(1), LoopStability(np.exp(1e-4 * growth), growth, 300.0))

    stage = SimpleNamespace(at="wheel", kind="none", anticipated=lambda speed: 1e6, level_two=lambda speed: 0.0)
    file = SimpleNamespace(stages=[stage], speed=SimpleNamespace(highest=1000.0), highest_frequency=1e3)
    monkeypatch.setattr(cross_coupling, "anticipated", lambda subject, factor: factor)
    monkeypatch.setattr(cross_coupling, "coupled_loop", lambda subject, factor: factor)
    monkeypatch.setattr(cross_coupling, "vibrations", vibrating)
    result = cross_coupling.result_of(SimpleNamespace(file=file))
    (ratio,) = [item.value for item in result.quantities if item.quantity == "cross_coupling_ratio"]
    assert ratio == pytest.approx(3.4 - 0.3 / np.sqrt(5.0), abs=1e-3)
