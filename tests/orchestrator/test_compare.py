"""Comparison of runs: table of differences, signals, figures, files, and errors of the command."""

import json
import math
import shlex
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import amb_cosim
from amb_cosim.comparison import compare as comparison
from amb_cosim.comparison.signals import compare_signals
from amb_cosim.comparison.table import rows_of
from amb_cosim.cosim.record.signals import Samples, SignalTable
from amb_cosim.cosim.run.recording import Outcome
from amb_cosim.presentation.text_tables import rendered
from amb_cosim.results.places import RotorPlaces
from amb_cosim.results.result import Result
from tests.support.messages import assert_names

DONE = Outcome("completed", 0.4)


@pytest.fixture
def make(synthetic):
    """`make(force=1.0, **attributes)`: a result whose contact force at RB1 is scaled."""

    def result(force: float = 1.0, outcome: Outcome = DONE, **attributes) -> Result:
        fields = [outcome.status, outcome.time, outcome.component, outcome.reason]
        dataset = synthetic(**{"outcome": json.dumps(fields)} | attributes)
        measured = dataset["rotor_contact.rb1.f_n"]
        dataset["rotor_contact.rb1.f_n"] = measured.copy(data=force * measured.values)
        return Result(dataset, outcome)

    return result


def row(found, quantity):
    return next(row for row in found.rows if row.quantity == quantity)


def test_differences_are_to_the_first_run(make):
    result = amb_cosim.compare(make(), make(force=1.5), make(force=0.5))
    peak = row(result, "peak_contact_force rb1")
    assert peak.unit == "N"
    assert peak.values == pytest.approx((1234.5, 1851.75, 617.25))
    assert peak.differences == pytest.approx((0.0, 617.25, -617.25))
    assert row(result, "peak_contact_force rb2").differences == (0.0, 0.0, 0.0)
    assert_names(rendered(result.text(whole=True)), "+50 %", "-50 %")


def test_verdicts_come_first_and_then_the_rows_of_each_run(make):
    """The second run is levitated: it has no contact and a margin. All other quantities are printed on request."""
    free = make(scenario="calm")
    for name in ("contact_state", "rb1.mode", "rb2.mode", "rb1.f_n", "rb2.f_n", "rb1.impulse", "rb2.impulse"):
        free.dataset[f"rotor_contact.{name}"] = free.dataset[f"rotor_contact.{name}"] * 0
    result = amb_cosim.compare(make(), free)
    first, second, *lines = str(result).splitlines()
    assert first == f"synthetic: {result.results[0].summary.verdict}"
    assert second == f"calm: {result.results[1].summary.verdict}"
    facts = {line.split("  ")[0]: line for line in lines}
    for side in result.results:
        for label, text in side.summary.verdict.facts:
            assert_names(facts[label], text)
    assert facts["time in contact"].rstrip().endswith("-")
    assert "cycle duration" not in facts
    assert "cycle duration" in rendered(result.text(whole=True))


def test_a_frequency_of_the_table_has_the_unit_of_the_summary(make):
    """The band of a summary is in Hz: 200 pi rad/s are 100 Hz."""
    places = RotorPlaces({"mb1": "rb1", "mb2": "rb2"}, ("rb1", "rb2"), valid_to=200.0 * math.pi, magnetic=("mb1",))
    text = rendered(amb_cosim.compare(*(make(places=places.to_json()) for _ in "ab")).text(whole=True))
    (band,) = (line for line in text.splitlines() if line.startswith("peak band"))
    assert band.split() == ["peak", "band", "Hz", "100", "100", "0"]
    assert "rad/s" not in text


@pytest.mark.parametrize(("whirl", "expected"), [("none", []), ("backward", [-5.0])])
def test_a_rotor_that_does_not_whirl_has_no_whirl_speed_in_the_table(make, whirl, expected):
    fallen = SimpleNamespace(retainers={"rb1": SimpleNamespace(whirl=whirl)})
    summary = replace(make().summary, whirl_speed={"rb1": -5.0}, touchdown=fallen)
    assert [item.values[0] for item in rows_of([summary]) if item.quantity == "whirl_speed rb1"] == expected


def test_rows_of_a_comparison_have_the_chosen_units(make):
    result = amb_cosim.compare(make(), make(force=1.5))
    with amb_cosim.units("kN", "um"):
        lines = rendered(result.text(whole=True)).splitlines()
    (peak,) = (line for line in lines if line.startswith("largest force between impacts rb1"))
    assert peak.split()[5:8] == ["kN", "1.234", "1.852"]
    assert [line for line in lines if " mm " in line] == []


def test_equal_runs_are_equal_to_the_last_bit(make):
    (against,) = amb_cosim.compare(make(), make()).signals.against_first
    assert against.same_times
    assert against.equal == against.compared > 20
    assert against.largest is None


def test_signal_with_the_largest_deviation_is_printed_with_its_cycle(make):
    (against,) = amb_cosim.compare(make(), make(force=1.5)).signals.against_first
    assert against.equal == against.compared - 1
    assert against.largest.signal == "rotor_contact.rb1.f_n"
    assert against.largest.difference == pytest.approx(0.5 * 1234.5)
    assert against.largest.cycle == pytest.approx(6.5)


@pytest.mark.parametrize("turns", [1, 2])
def test_angles_beside_the_end_of_a_turn_differ_by_little(turns):
    """An angle of many turns does not start again, so a whole turn counts there."""
    time = np.linspace(0.0, 1.0, 50)

    def run(behind):
        angle = 2.0 * math.pi * turns * time - behind
        angle = angle % (2.0 * math.pi) if turns == 1 else angle + 2.0 * math.pi * (behind > 0.0)
        signals = {"rotor_contact.theta": ("time", angle, {"units": "rad"}), "cycle": ("time", time)}
        return xr.Dataset(signals, {"time": time})

    (against,) = compare_signals("ab", [run(0.0), run(0.01)]).against_first
    assert against.largest.signal == "rotor_contact.theta"
    assert against.largest.difference == pytest.approx(0.01 if turns == 1 else 2.0 * math.pi - 0.01)


def test_signals_missing_in_some_runs_are_reported(make):
    less = make()
    dataset = less.dataset.drop_vars("rotor_contact.energy.strain")
    result = amb_cosim.compare(make(), Result(dataset.assign_attrs(scenario="lean"), DONE))
    assert result.signals.only_some == {"rotor_contact.energy.strain": ("synthetic",)}
    assert "only in synthetic: rotor_contact.energy.strain" in str(result)


@pytest.fixture
def runs(make, monkeypatch):
    """Calls of `run`, which does not run."""
    calls = []

    def run(scenario, **options):
        calls.append((scenario.name, options))
        return make(scenario=scenario.name)

    monkeypatch.setattr(comparison, "run", run)
    return calls


def test_options_apply_to_all_runs_or_to_a_single_run(runner, runs):
    options = "--set a.b=1 --set '2:a.c=2 mm' --rotor 1:bath_rig --flavour 2:python --until 0.1 --no-plots"
    result = runner("compare", "fig4_9", "fig4_9", *shlex.split(options))
    assert result.exit_code == 0, result.output
    (_, first), (_, second) = runs
    assert (first["set"], second["set"]) == ({"a.b": "1"}, {"a.b": "1", "a.c": "2 mm"})
    assert (first["rotor"], second["rotor"]) == ("bath_rig", None)
    assert (first["flavour"], second["flavour"]) == ("native", "python")
    assert first["until"] == second["until"] == "0.1"
    labels = [run["label"] for run in json.loads(Path("results/comparison/comparison.json").read_text())["runs"]]
    assert labels == ["fig4_9, a.b=1, bath_rig, native", "fig4_9, a.b=1, a.c=2 mm, python"]


def test_saved_results_give_table_figures_and_data(make, runner, check_picture, tmp_path):
    make().save(tmp_path / "a", plots=False)
    make(force=2.0, scenario="heavy").save(tmp_path / "b", plots=False)
    result = runner("compare", "a", "b/result.nc", "-o", "out", "--all")
    assert result.exit_code == 0, result.output
    assert "+100 %" in result.stdout
    assert "results in out" in result.stdout
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == ["comparison.json", "contact.png", "displacement.png", "orbits.png"]
    for name in names[1:]:
        check_picture(tmp_path / "out" / name)
    data = json.loads((tmp_path / "out" / "comparison.json").read_text(), parse_constant=pytest.fail)
    assert [run["label"] for run in data["runs"]] == ["synthetic", "heavy"]
    peak = next(row for row in data["rows"] if row["quantity"] == "peak_contact_force rb1")
    assert peak["differences"] == pytest.approx([0.0, 1234.5])


def test_a_fault_of_a_figure_hides_neither_verdict_nor_comparison(make, runner, monkeypatch, tmp_path):
    def fails(*_):
        raise KeyError("journal_radius")

    monkeypatch.setattr("amb_cosim.results.plots.draw_all", fails)
    monkeypatch.setattr("amb_cosim.comparison.plots.overlays", fails)
    monkeypatch.setattr("amb_cosim.scenario.simulation.run", lambda *_, **__: make())
    make().save(tmp_path / "a", plots=False)
    for command, file in (("run fig4_9 -o out", "summary.json"), ("compare a a -o out", "comparison.json")):
        result = runner(*command.split())
        assert isinstance(result.exception, KeyError)
        assert "recovered: the rotor touched" in result.stdout
        assert (tmp_path / "out" / file).is_file()


def test_run_that_failed_is_compared_and_reported(make, runner, tmp_path):
    make().save(tmp_path / "a", plots=False)
    make(outcome=Outcome("failed", 0.3, "rotor_contact", "too fast")).save(tmp_path / "b", plots=False)
    result = runner("compare", "a", "b", "-o", "out", "--no-plots")
    assert result.exit_code == 1
    assert "synthetic (2): rotor_contact failed at t = 0.3 s: too fast" in result.stderr
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["comparison.json"]


def record(**signals):
    """Signals of 100 samples by name, with the unit and the values of each."""
    time = np.linspace(0.0, 0.1, 100)
    values = {
        f"rotor_contact.{name}": Samples(np.resize(v, 100), {"units": unit}) for name, (unit, v) in signals.items()
    }
    return SignalTable(values, {"time": Samples(time, {}), "cycle": Samples(time, {})}, {})


def deviating(**changed):
    """The signal that a comparison names if these signals differ."""
    signals = {
        **{"x": ("m", [-1e-3, 1e-3]), "still": ("m", [0.0]), "f": ("N", [0.0, 1e3])},
        **{"balance": ("J", [0.0, 1e-6]), "heat": ("J", [0.0, 50.0]), "flag": ("1", [0.0, 1.0])},
    }
    (against,) = compare_signals(["a", "b"], [record(**signals), record(**signals | changed)]).against_first
    return against.largest and against.largest.signal.removeprefix("rotor_contact.")


def test_the_signal_named_is_a_motion_or_a_force_rather_than_a_flag_or_a_balance():
    """The balance differs by a hundred times its range, the flag by all of it, the orbit by a tenth."""
    balance, flag, x = ("J", [0.0, 1e-4]), ("1", [1.0, 0.0]), ("m", [-1.1e-3, 1.1e-3])
    assert deviating(balance=balance, flag=flag, x=x) == "x"
    assert deviating(balance=balance, flag=flag) == "balance"
    assert deviating(flag=flag) == "flag"
    assert deviating(balance=balance, heat=("J", [0.0, 45.0])) == "heat"


def test_a_motion_counts_relative_to_those_in_its_unit():
    """The sixth digit of a site at rest is not what differs most from a run with twice the force."""
    assert deviating(still=("m", [0.0, 1e-7]), f=("N", [0.0, 2e3])) == "f"
    assert deviating(x=("m", [-1e-3, 1e-3 + 1e-15]), heat=("J", [0.0, 45.0])) == "heat"
    assert deviating() is None
