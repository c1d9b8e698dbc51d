"""Unbalance in runs and responses: its placement, and the worst speed and fault between those of a list."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from amb_analysis.machine.machine import Place
from amb_assessment.assessment.analyses import critical_map, envelope, faults, unbalance, vibration
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.physics import runs
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of, rpm
from amb_assessment.assessment.physics.runs import placed_unbalances, planes_of_unbalance, worst_response
from amb_assessment.assessment.physics.unbalance_cases import base_notes, unbalance_cases
from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.results.component_names import PLANT

BLOWER = Path(__file__).parent / "blower" / "machine.toml"
RPM = np.pi / 30.0
CLEARANCE = 0.2e-3


def expander(**speed):
    """The packaged turbo-expander at G 2.5, with a resonance at 35,650 rpm within its speeds."""
    file = load_machine("turbo_expander")
    speeds = file.speed.model_copy(update=speed)
    return assessed_machine_of(
        file.model_copy(update={"balancing": type(file.balancing)(grade="G 2.5"), "speed": speeds})
    )


@pytest.mark.parametrize("machine", [BLOWER, "compressor", "turbo_expander"])
def test_all_unbalance_is_placed_with_the_signs_of_the_mode(machine):
    subject = assessed_machine_of(load_machine(machine))
    planes, whole = planes_of_unbalance(subject), subject.unbalance_of_grade()
    for placed in placed_unbalances(subject):
        assert sum(abs(u) for u in placed.at.values()) == pytest.approx(whole)
        shape = {plane: placed.case.shape[planes[plane] - 1] for plane in placed.at}
        assert all(u * shape[plane] > 0.0 for plane, u in placed.at.items())


def test_a_rotor_with_a_single_disc_has_the_whole_unbalance(tmp_path):
    """Lobes of opposite sign do not subtract at its only disc: a lobe without a disc has its unbalance at a bearing."""
    rotor = (BLOWER.parent / "rotor.toml").read_text(encoding="utf-8")
    head, *others = rotor.split("unbalance = true\n")
    (tmp_path / "rotor.toml").write_text(f"{head}unbalance = true\n{''.join(others)}", encoding="utf-8")
    file = load_machine(BLOWER).model_copy(update={"rotor": str(tmp_path / "rotor.toml")})
    subject = assessed_machine_of(file)
    assert [disc.name for disc in subject.rotor.discs] == ["impeller"]
    for placed in placed_unbalances(subject):
        amounts = [u for name, u in placed.inputs.items() if name.endswith(".u")]
        assert sum(amounts) == pytest.approx(subject.unbalance_of_grade())
    worst = worst_response(subject, subject.file.speed.lowest, subject.file.speed.highest)
    assert worst.share > 0.014  # as with three discs, a tenth of that where they subtracted


@pytest.mark.parametrize("lowest", ["34000 rpm", "35543 rpm"])
def test_vibration_is_judged_at_the_resonance_within_the_speeds(lowest):
    """Three speeds of the range miss the resonance; the narrower range ends beside it. Both exceed 50 %."""
    result = vibration.result_of(expander(minimum=lowest))
    worst = max(result.quantities, key=lambda quantity: quantity.value)
    assert worst.value > 50.0
    speeds = {float(quantity.where.split(" at ")[1].split()[0]) for quantity in result.quantities}
    assert any(speed == pytest.approx(35650.0, rel=0.002) for speed in speeds)
    assert {float(lowest.split()[0]), 40000.0} <= speeds


def test_worst_speed_of_a_range_is_that_of_many_speeds():
    subject = expander()
    worst = worst_response(subject, subject.file.speed.lowest, subject.file.speed.highest)
    for Omega in np.linspace(35600.0, 35800.0, 21) * RPM:
        assert worst_response(subject, float(Omega), float(Omega)).share <= worst.share * (1.0 + 1e-3)


def test_envelope_has_the_demand_of_a_resonance_between_its_speeds():
    result = envelope.result_of(expander())
    demand = max(item.value for item in result.quantities if item.quantity == "current_demand")
    assert demand == pytest.approx(129.4 * 3.0 / 2.5, rel=0.01)  # of the bias 129.4 %; 2.5 A of 3 A are allowed


def test_largest_voltage_is_found_where_the_current_has_no_maximum(monkeypatch):
    """V = R (I_0 + I_s) + I |R + j Omega L| of a current that falls with the speed, with a shoulder at 2000 rad/s."""
    subject = expander()
    axes = [subject.axis(bearing, axis) for bearing, axis in subject.loop.axes]

    def current(Omega):
        return 1000.0 / Omega + 0.125 / (1.0 + ((Omega - 2000.0) / 500.0) ** 2)

    def needed(subject, speeds, q):
        return np.zeros((len(speeds), len(axes))), np.tile(current(speeds)[:, None], len(axes))

    monkeypatch.setattr(envelope, "largest_needed", needed)
    monkeypatch.setattr(envelope, "POINTS", 12)
    (table,) = envelope.result_of(subject).tables
    Omega = np.linspace(1500.0, 2500.0, 10001)
    for p, row in zip(axes, table.rows, strict=True):
        voltages = p.resistance * (p.bias_current + p.static_current) + current(Omega) * np.hypot(
            p.resistance, Omega * p.inductance
        )
        assert float(row[4].split()[0]) == pytest.approx(voltages.max(), rel=1e-3)


@pytest.mark.parametrize(("minutes", "touches"), [(None, True), ("10 s", True), ("0.2 s", False)])
def test_a_slow_run_up_counts_as_steady_motion_at_the_worst_speed(minutes, touches):
    """A run-up within 0.2 s passes the resonance before it has grown; in 10 s, or without a time, the rotor touches."""
    subject = expander(run_up=minutes, run_down="0.2 s")
    passed = worst_response(subject, 0.1 * subject.file.speed.highest, subject.file.speed.tripping)
    assert rpm(passed.Omega) == pytest.approx(35650.0, rel=0.002)
    time = faults._durations(subject)["run-up"]
    quantity, _ = faults._running(subject, "run-up", time, passed)
    assert (quantity.value > 99.9) is touches
    if not touches:
        assert quantity.value < 60.0


def test_a_run_begins_when_the_motion_of_the_start_has_decayed():
    """The turbo-expander at its trip speed: with 20 cycles of settling its first cycles moved half as far again."""
    subject = assessed_machine_of(load_machine("turbo_expander"))
    trip = subject.file.speed.tripping
    assert runs.settling_cycles(subject, trip) > 60.0
    inputs = worst_response(subject, trip, trip).unbalance.inputs
    used = runs.clearance_used(subject, runs.simulate(subject, trip, inputs, end_cycle=20))
    for of in used.values():
        first, last = of[: len(of) // 4].max(), of[-len(of) // 4 :].max()
        assert first == pytest.approx(last, rel=0.03)


@pytest.mark.parametrize(("decay", "cycles"), [(200.0, 20.0), (20.0, 37.0), (1e-3, 400.0)])
def test_settling_follows_the_slowest_vibration_that_the_start_excites(decay, cycles):
    """n = ln(100) Omega/(2 pi sigma); drifts, faster vibrations and growing ones do not count."""
    s = np.array([-decay + 500j, -decay - 500j, -1e-6, -1e-6 + 2500j, 1.0 + 300j])
    loop = SimpleNamespace(poles=lambda Omega: SimpleNamespace(s=s))
    assert runs.settling_cycles(SimpleNamespace(loop=loop), 1000.0) == pytest.approx(cycles)


def test_drag_gives_the_time_of_a_run_down():
    """J Omega' = -d Omega: t = J/d ln(trip/slow); a machine without drag may take any time."""
    subject = expander()
    local = subject.parameters["rotor_contact"]
    times = faults._durations(subject)
    assert times["run-down"] == pytest.approx(local["spin.inertia"] / local["spin.drag"] * np.log(10.5))
    assert faults._durations(assessed_machine_of(load_machine(BLOWER)))["run-down"] == np.inf


def test_every_fault_is_a_disturbance_so_that_it_has_an_outcome():
    """Without one, a shock that threw the rotor into its retainers was listed without contact."""
    cases = [events for kind in faults._kinds(expander()).values() for events in kind.values()]
    assert [sum(event.get("role") == "disturbance" for event in events) for events in cases] == [1] * len(cases)
    assert all(events[0]["role"] == "disturbance" for events in cases)


@pytest.mark.slow
def test_the_worst_axis_and_sensor_stand_for_a_fault():
    result = faults.result_of(assessed_machine_of(load_machine(BLOWER)))
    (table,) = result.tables
    kinds = {"power of": 4, "upper coils of": 4, "lower coils of": 4, "sensor": 4, "base shock": 4}
    for kind, count in kinds.items():
        assert sum(row[0].startswith(kind) for row in table.rows) == count
    measured = [item.value for item in result.quantities if item.quantity == "clearance_used_fault"]
    assert len(measured) == 4
    for kind, value in zip(("power", ("upper", "lower"), "sensor", "base"), measured, strict=True):
        assert value == pytest.approx(max(float(row[2]) for row in table.rows if row[0].startswith(kind)), rel=0.01)


def test_bearings_that_differ_along_x_and_y_have_two_maps():
    """The blower with half the gain along x of one bearing; with equal axes there is one direction."""
    file = load_machine(BLOWER)
    weak = assessed_machine_of(file.model_copy(update={"controller": str(BLOWER.parent / "one_axis_weak.toml")}))
    first, other = (
        {item.where for item in critical_map.result_of(of).quantities} for of in (assessed_machine_of(file), weak)
    )
    assert not any(" along " in where for where in first)
    assert all(where.endswith((" along x", " along y")) for where in other)
    assert {where.rpartition(" ")[2] for where in other} == {"x", "y"}
    assert {case.name.split(" (")[0] for case in unbalance_cases(weak)} >= {"mode 1 along x", "mode 1 along y"}


def test_share_of_the_clearance_grows_with_the_unbalance(monkeypatch):
    """The scale factor is never below one: beyond the limit, ten times the unbalance gives ten times the share."""
    subject = assessed_machine_of(load_machine(BLOWER))
    shares = {}
    for factor in (20.0, 200.0):
        monkeypatch.setattr(unbalance, "FACTOR", factor)
        measured = unbalance.result_of(subject).quantities
        shares[factor] = [item.value for item in measured if item.quantity == "clearance_share"]
        assert all(item.facts["S_cc"] == 1.0 for item in measured if item.quantity == "clearance_share")
    assert shares[200.0] == pytest.approx([10.0 * share for share in shares[20.0]])


def test_a_bounce_between_samples_uses_the_whole_clearance():
    """At the ends of the steps the journal is 3 % or more from its retainer, which it hits in one of them."""
    x = CLEARANCE * np.array([0.9, 0.95, 0.97, 0.9])
    values = {
        "catcher.x": x,
        "catcher.y": 0.0 * x,
        "catcher.mode": 0.0 * x,
        "catcher.impulse": np.array([0, 0, 0.1, 0]),
    }
    signals = SignalTable(
        {f"{PLANT}.{name}": Samples(value, {}) for name, value in values.items()},
        {"time": Samples(1e-4 * np.arange(4), {})},
        {},
    )
    subject = SimpleNamespace(clearances={"catcher": Place(3, CLEARANCE, "catcher")}, rotor=SimpleNamespace(faces=()))
    used = runs.clearance_used(subject, SimpleNamespace(signals=signals))["catcher"]
    np.testing.assert_allclose(used, [0.9, 0.95, 1.0, 0.9])


@pytest.mark.parametrize("speeds", [(100.0, 200.0, 300.0), (150.0, 250.0), (200.0, 300.0)])
def test_a_critical_speed_at_a_computed_speed_is_found_once(monkeypatch, speeds):
    """A rotor whose only critical speed is 200 rad/s, whatever the stiffness of its bearings."""
    monkeypatch.setattr(critical_map, "critical_speeds", lambda rotor, springs, count: (np.array([200.0]), None))
    subject = SimpleNamespace(bearings={"a": 1}, magnets=("a",), free=None)
    found = critical_map.bearing_critical_speeds(subject, np.array(speeds), {"a": np.full(len(speeds), 1e6)})
    assert found == [(1, pytest.approx(200.0))]


def test_shapes_on_a_base_at_rest_name_what_moves_the_base():
    assert base_notes(SimpleNamespace(base_movers=())) == []
    (note,) = base_notes(SimpleNamespace(base_movers=("casing", "skid")))
    assert "casing, skid" in note
    assert "at rest" in note
