"""Magnets that are nearer to the rotor than its retainers: displacements count against the air gap there."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from machine_variants import read, toml_text

from amb_assessment.assessment.analyses import faults, recovery, unbalance, vibration
from amb_assessment.assessment.engine.findings import Judgement, judge
from amb_assessment.assessment.format.criteria import load_criteria
from amb_assessment.assessment.format.machine_file import load_machine
from amb_assessment.assessment.physics import runs
from amb_assessment.assessment.physics.assessed_machine import assessed_machine_of
from amb_cosim.results.component_names import ACTUATOR, PLANT
from tests.support.messages import assert_names

BLOWER = Path(__file__).parent / "blower"
GAP = 0.4e-3  # m, of its magnets; its retainers have 0.2 mm
AIR_GAPS = ("air gap of amb_a", "air gap of amb_b")


def blower(folder, clearance, in_planes=False):
    """The blower with other retainers, in separate planes or in those of the magnets."""
    shutil.copytree(BLOWER, folder, dirs_exist_ok=True)
    rotor = folder / "rotor.toml"
    text = (BLOWER / "rotor.toml").read_text(encoding="utf-8")
    assert text.count("clearance = 0.2e-3") == 2
    if in_planes:
        text = text.replace("z = 0.125", "z = 0.225").replace("z = 0.810", "z = 0.725")
    rotor.write_text(text.replace("clearance = 0.2e-3", f"clearance = {clearance}"), encoding="utf-8")
    return assessed_machine_of(load_machine(folder / "machine.toml"))


def judged(subject, measured):
    return [item for item in judge(measured, load_criteria(), subject.facts) if item.criterion is not None]


def test_share_of_an_air_gap_is_that_of_a_retainer_in_its_plane(tmp_path):
    """Retainers in the planes of the magnets: 0.3 mm are nearer than the air gap of 0.4 mm, 0.6 mm are not."""
    shares = {}
    for clearance in (0.3e-3, 0.6e-3):
        measured = unbalance.result_of(blower(tmp_path, f"{clearance}", in_planes=True)).quantities
        shares[clearance] = {item.where: item.value for item in measured if item.quantity == "clearance_share"}
    assert {where.split(",")[0] for where in shares[0.3e-3]} == {"td_a", "td_b"}
    assert {where.split(",")[0] for where in shares[0.6e-3]} == set(AIR_GAPS)
    for where, share in shares[0.3e-3].items():
        other = shares[0.6e-3][where.replace("td_", "air gap of amb_", 1)]
        assert other == pytest.approx(share * 0.3e-3 / GAP, rel=1e-6)


def test_the_nearest_stop_is_the_one_with_the_largest_used_share(tmp_path):
    subject = blower(tmp_path, "0.6e-3")
    shares = {"td_a": 0.3, "td_b": 0.4, "labyrinth": 0.1, "air gap of amb_a": 0.5, "air gap of amb_b": 0.2}
    assert subject.nearest(shares) == ["air gap of amb_a", "td_b", "labyrinth"]
    assert subject.stops == ("td_a", "td_b", *AIR_GAPS)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize(
    ("gap", "decisive"), [(0.2, {"td_a", "other"}), (0.4, {"td_a", "other"}), (0.6, {"air gap of amb_a"})]
)
def test_a_magnet_between_two_retainers_is_reached_first_or_not_at_all(order, gap, decisive, tmp_path):
    """The air gap decides if it is used more than both retainers, whichever is the last in the file."""
    shutil.copytree(BLOWER, tmp_path, dirs_exist_ok=True)
    rotor = read(tmp_path / "rotor.toml")
    other = {"name": "other", "z": 0.3, "bearing": "amb_a", "clearance": 0.2e-3}
    text = toml_text(rotor | {"sites": [*rotor["sites"], other][::order]})
    (tmp_path / "rotor.toml").write_text(text, encoding="utf-8")
    subject = assessed_machine_of(load_machine(tmp_path / "machine.toml"))
    used = {"td_a": 0.3, "other": 0.5, "td_b": 0.4, "air gap of amb_a": gap, "air gap of amb_b": 0.2}
    shares = {place: used[place] for place in subject.clearances}
    assert {*subject.nearest(shares)} == {*decisive, "td_b"}


def test_vibration_is_the_orbit_over_the_air_gap_that_is_nearer(tmp_path):
    """With retainers of 2 mm the magnets of 0.4 mm decide at both bearings, with the orbits of a separate run."""
    subject = blower(tmp_path, "2e-3")
    items = {item.where: item for item in vibration.result_of(subject).quantities}
    assert {where.split(" at ")[0] for where in items} == set(AIR_GAPS)
    Omega = subject.file.speed.highest
    inputs = runs.worst_response(subject, Omega, Omega).unbalance.inputs
    signals = runs.simulate(subject, Omega, inputs, end_cycle=20).signals
    settled = np.asarray(signals["time"].values) >= 0.0
    for bearing in subject.magnets:
        x, y = (np.asarray(signals[f"{PLANT}.{bearing}.{axis}"].values)[settled] for axis in "xy")
        item = items[f"air gap of {bearing} at 24000 rpm"]
        assert item.value == pytest.approx(100.0 * np.hypot(x, y).max() / GAP, rel=0.15)
        assert_names(item.note, "0.4 mm")


def test_offset_of_a_retainer_adds_to_the_orbit(tmp_path):
    """By 50 um of 200 um, a quarter of the clearance, in steady response as in co-simulation."""
    centred = blower(tmp_path, "0.2e-3")
    machine = tmp_path / "machine.toml"
    text = machine.read_text(encoding="utf-8")
    table = '[parameters.rotor_contact]\n"td_a.offset_x" = "-30 um"\n"td_a.offset_y" = "40 um"\n'
    header = "[parameters.rotor_contact]\n"
    machine.write_text(text.replace(header, table) if header in text else text + "\n" + table, encoding="utf-8")
    offset = assessed_machine_of(load_machine(machine))
    shares = [
        {item.where: item.value for item in unbalance.result_of(of).quantities if item.quantity == "clearance_share"}
        for of in (centred, offset)
    ]
    assert shares[1] == pytest.approx({where: of + 25.0 * ("td_a" in where) for where, of in shares[0].items()})
    Omega = centred.file.speed.highest
    steady = runs.worst_response(offset, Omega, Omega)
    assert steady.shares["td_a"] == pytest.approx(0.25 + runs.worst_response(centred, Omega, Omega).shares["td_a"])
    used = runs.clearance_used(offset, runs.simulate(offset, Omega, steady.unbalance.inputs, end_cycle=20))
    assert used["td_a"].max() == pytest.approx(steady.shares["td_a"], abs=0.02)


def test_a_rotor_that_lies_on_a_magnet_uses_all_of_its_gap(tmp_path):
    """Without power in one axis the rotor falls onto the bore at 67 % of the retainers' 0.6 mm."""
    subject = blower(tmp_path, "0.6e-3")
    used = runs.clearance_used(subject, runs.simulate(subject, subject.file.speed.highest, end_time=0.1, **LOST))
    largest = {place: float(of.max()) for place, of in used.items()}
    assert largest["air gap of amb_a"] == pytest.approx(1.0, rel=2e-3)
    assert largest["td_a"] < 0.9


LOST = {"event": [{"role": "disturbance", "cycle": 1.0, "set": {ACTUATOR: {"amb_a.amplifier_off_x": True}}}]}


def test_a_fault_that_ends_at_a_magnet_uses_the_whole_gap(tmp_path, monkeypatch):
    """Without its upper coils an axis pulls the rotor across the gap, which ends the run."""
    subject = blower(tmp_path, "0.6e-3")
    kinds = faults._kinds(subject)
    (kind,) = (name for name in kinds if name.startswith("coils"))
    name, events = next(iter(kinds[kind].items()))
    monkeypatch.setattr(faults, "_kinds", lambda _: {kind: {name: events}})
    (measured,), (row,), (curve,) = faults._faults(subject)
    assert measured.value == pytest.approx(100.0, abs=3.0)
    assert measured.value >= 100.0
    assert_names(measured.where, "air gap of amb_a")
    assert max(curve.y) == pytest.approx(measured.value, rel=0.01)
    assert_names(" ".join(row), "ends at the magnet")


def test_a_run_that_ends_early_away_from_a_magnet_is_an_error(tmp_path):
    """A base acceleration of 1e9 m/s^2 is refused before the rotor reaches a magnet."""
    subject = blower(tmp_path, "0.6e-3")
    shoved = [{"role": "disturbance", "cycle": 1.0, "set": {PLANT: {"base.a_x": 1e9}}}]
    with pytest.raises(ValueError, match="ended early"):
        runs.simulate(subject, subject.file.speed.highest, end_time=0.1, event=shoved)


@pytest.mark.slow
def test_a_rotor_that_stays_at_a_magnet_has_not_relevitated(tmp_path):
    subject = blower(tmp_path, "0.6e-3")
    items = {item.quantity: item for item in recovery.result_of(subject).quantities}
    (verdict,) = judged(subject, [items["relevitation"]])
    assert verdict.verdict is Judgement.FAILED
    assert_names(items["relevitation"].where, "air gap of")
    assert_names(items["overload"].where, "air gap of")
    assert 0.25 <= items["overload"].value < 8.0
    assert np.isfinite(items["overload"].value)
