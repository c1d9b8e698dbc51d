"""Key values of contact do not depend on the recording interval."""

import dataclasses

import pytest
from strange_machine import TOUCHDOWN

import amb_cosim
from amb_cosim.cosim.record import step_rows
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.results import plots
from amb_cosim.results.contact_forces import averaged_force, peaks, received_impulse
from amb_cosim.results.plots.contact import touched_sites
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from tests.support.messages import assert_names

OF_CONTACT = (
    "peak_contact_force",
    "peak_is_sampled",
    "averaged_contact_force",
    "peak_impulse",
    "contact_share",
    "site_share",
    "first_contact",
    "last_contact",
    "recovery",
    "rolling_from",
    "rolling_on_race_from",
    "whirl_speed",
    "share_beyond_reduction",
    "steps_by_method",
    "energy",
    "energy_balance",
    "energy_balance_of_heat",
    "warnings",
)
OF_SAMPLES = ("drop", "orbit", "rest_after", "rocks_within")  # of a touchdown; all else is the same


def thinned(every, **options):
    scenario = load_scenario(str(TOUCHDOWN))
    return amb_cosim.run(scenario.changed(record={"every": every}), **options)


@pytest.fixture(scope="module")
def thin():
    return thinned(100)


def test_a_thinned_record_follows_the_rules_that_fmus_declare():
    """Samples would miss what happened between them, also at outputs that no summary knows."""
    assembly = prepare_run(load_scenario(str(TOUCHDOWN))).assembly
    experiment = Experiment(1e-4, 0.01, record_every=10, each={"rotor_contact.catch_n.temperature": "largest"})
    each = experiment_plan(experiment, assembly).recorded_each
    at_site = {name: rule for name, rule in each.items() if name.startswith("rotor_contact.catch_n.")}
    assert at_site == {
        "rotor_contact.catch_n.f_n_peak": "largest",
        "rotor_contact.catch_n.f_n_mean": "mean",
        "rotor_contact.catch_n.impulse": "sum",
        "rotor_contact.catch_n.temperature": "largest",
    }


@pytest.mark.parametrize("every", [4, 20, 100])
def test_contact_figures_do_not_depend_on_thinning(every, touchdown, request):
    run = request.getfixturevalue("thin") if every == 100 else thinned(every)
    result, full = run.summary, touchdown.summary
    assert {name: getattr(result, name) for name in OF_CONTACT} == {name: getattr(full, name) for name in OF_CONTACT}
    fall, of_full = (dataclasses.asdict(summary.touchdown) for summary in (result, full))
    assert {name: fall[name] for name in fall if name not in OF_SAMPLES} == {
        name: of_full[name] for name in of_full if name not in OF_SAMPLES
    }


def test_a_thinned_run_has_few_samples_and_marks_its_orbits_as_sampled(thin, touchdown):
    assert thin.signals.sizes["time"] < touchdown.signals.sizes["time"] / 90
    (notice,) = set(thin.summary.notices) - set(touchdown.summary.notices)
    assert_names(notice, "100 steps", "sampled", "record.every = 1")


def test_a_file_of_a_thinned_run_has_the_same_summary(thin, tmp_path):
    loaded = amb_cosim.Result.load(thin.save(tmp_path, plots=False))
    assert loaded.summary.as_dict() == thin.summary.as_dict()


def test_a_long_run_has_rows_of_steps_with_the_same_largest_forces(monkeypatch, touchdown):
    """Times are those of rows of 0.5 ms, and forces averaged over 1 ms begin with one."""
    monkeypatch.setattr(step_rows, "MOST_ROWS", 10)  # as many steps as make rows of ten of them
    rows, full = thinned(100), touchdown.summary
    steps = rows.dataset["step_time"].values
    assert len(steps) < len(touchdown.signals["time"].values) / 9
    assert rows.summary.peak_contact_force == full.peak_contact_force
    assert rows.summary.peak_is_sampled == full.peak_is_sampled
    for site, force in full.averaged_contact_force.items():
        assert rows.summary.averaged_contact_force[site] == pytest.approx(force, rel=0.25)
        impulse, all_steps = (received_impulse(run.signals, site)[-1] for run in (rows, touchdown))
        assert impulse == pytest.approx(all_steps, rel=1e-9)
    balance = full.energy["balance"]  # the largest, here of the ends of rows
    assert rows.summary.energy == {**full.energy, "balance": pytest.approx(balance, rel=0.1)}
    period = touchdown.signals.attrs["period_s"]
    assert rows.summary.first_contact == pytest.approx(full.first_contact, abs=0.5e-3 / period)
    assert rows.summary.recovery == full.recovery
    assert rows.summary.touchdown.retainers.keys() == full.touchdown.retainers.keys()


@pytest.mark.parametrize(("most_rows", "moment"), [(step_rows.MOST_ROWS, "30.5 ms"), (10, "30.35 ms")])
def test_a_thinned_run_is_the_same_in_the_plain_loop_and_continued(most_rows, moment, tmp_path, monkeypatch):
    """With the values of each step, and with rows of ten steps, as of a long run."""
    monkeypatch.setattr(step_rows, "MOST_ROWS", most_rows)
    whole = thinned(100, save_at=[moment])
    assert thinned(100, loop="plain").dataset.equals(whole.dataset)
    checkpoint = whole.checkpoint().save(tmp_path / "state.npz")
    assert thinned(100, start=checkpoint).dataset.equals(whole.dataset)


def test_forces_at_thinned_samples_are_the_largest_of_all_steps(thin, touchdown):
    for site in touchdown.summary.averaged_contact_force:
        full = averaged_force(touchdown.signals, site)
        largest = [full[0], *(max(full[end - 99 : end + 1]) for end in range(100, len(full), 100))]
        assert averaged_force(thin.signals, site) == pytest.approx(largest)
        assert peaks(thin.signals, site).max() == peaks(touchdown.signals, site).max()


def test_figures_of_a_thinned_run_mark_the_forces_of_its_summary(thin, touchdown):
    """The first impacts are enlarged with the values of every step, and not where straight lines would join samples."""
    (site, force), *_ = touched_sites(thin.signals).items()
    assert force.marked[1] == pytest.approx(touchdown.summary.averaged_contact_force[site])
    of_thin, of_full = (plots.figure(run.signals, "contact").axes for run in (thin, touchdown))
    assert of_thin[-1].get_xlim() == pytest.approx(of_full[-1].get_xlim())
    column = len(of_full) // 2
    curves = [axes[column].get_lines()[1].get_xydata() for axes in (of_thin, of_full)]
    begin, end = of_full[-1].get_xlim()
    drawn = [curve[(begin <= curve[:, 0]) & (curve[:, 0] <= end)] for curve in curves]
    assert drawn[0] == pytest.approx(drawn[1], rel=1e-6, abs=1e-9)
    assert not [inset for axes in plots.figure(thin.signals, "touchdown").axes for inset in axes.child_axes]
