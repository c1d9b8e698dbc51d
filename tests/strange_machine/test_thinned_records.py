"""Key values, spectra and figures do not depend on the recording interval, or say what it hides."""

from dataclasses import replace

import numpy as np
import pytest
from strange_machine import LEVITATION, RUB, TOUCHDOWN

import amb_cosim
from amb_analysis.measured.estimates import estimate
from amb_analysis.measured.files import read_measured
from amb_analysis.measured.run_data import read_run
from amb_cosim import studies
from amb_cosim.cosim.record import step_rows
from amb_cosim.cosim.run.dataset import save
from amb_cosim.cosim.system.experiment import Experiment
from amb_cosim.cosim.system.planning import experiment_plan
from amb_cosim.results import plots
from amb_cosim.results.contact_forces import averaged_force, peaks, received_impulse
from amb_cosim.results.plots.contact import touched_sites
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from amb_sweeps.metrics import evaluate
from tests.support.messages import assert_names, raises_naming

CLOCK = ("wall_s", "real_time_factor")  # differ between any two runs
STEP, SPIN = 50e-6, 250.0  # s, and turns per s, of the levitated expander


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


def key_values(run):
    """Return all values of a summary, and the lines of its verdict, except the clock and the times of warnings."""
    values = {name: value for name, value in run.summary.as_dict().items() if name not in (*CLOCK, "warnings")}
    warned = [sentence.partition(";")[0] for sentence in run.summary.warnings]
    return values, warned, str(run.summary.verdict), run.summary.verdict.facts


def test_shares_of_warnings_are_those_of_the_samples():
    """The demand is at its limit for 0.125 % of the time, in two steps; a sample per 37 steps shows none of them."""
    run = amb_cosim.run(load_scenario(str(RUB)).changed(record={"every": 37}))
    (limited,) = (sentence for sentence in run.summary.warnings if "current_limited" in sentence)
    assert_names(limited, "0.01645 s", "less than 0.1 % of the samples")


@pytest.mark.parametrize("every", [4, 20, 100])
def test_key_values_do_not_depend_on_thinning(every, touchdown, request):
    """Orbits, drop, rest and margin are those of all steps, like contact."""
    run = request.getfixturevalue("thin") if every == 100 else thinned(every)
    assert key_values(run) == key_values(touchdown)


@pytest.mark.parametrize(("scenario", "full"), [(LEVITATION, "levitation"), (RUB, "rub")])
def test_orbits_currents_and_forces_are_largest_of_all_steps(scenario, full, request):
    """37 steps are half a turn, so samples miss the largest orbit, current and force."""
    run = amb_cosim.run(load_scenario(str(scenario)).changed(record={"every": 37}))
    full = request.getfixturevalue(full)
    assert key_values(run) == key_values(full)
    assert evaluate(run.signals) == evaluate(full.signals)
    x, y = (full.signals[f"rotor_contact.north.{axis}"].values for axis in "xy")
    assert run.summary.orbit_largest["north"] == pytest.approx(1e3 * np.hypot(x, y).max(), rel=1e-12)


def test_a_thinned_run_has_few_samples(thin, touchdown):
    assert thin.signals.sizes["time"] < touchdown.signals.sizes["time"] / 90


def test_a_file_of_a_thinned_run_has_the_same_summary(thin, tmp_path):
    loaded = amb_cosim.Result.load(thin.save(tmp_path, plots=False))
    assert loaded.summary.as_dict() == thin.summary.as_dict()


def test_a_long_run_has_rows_of_steps_with_the_same_largest_forces(monkeypatch, touchdown):
    """Times are those of rows of 0.5 ms, forces averaged over 1 ms begin with one, and orbits are marked as sampled."""
    monkeypatch.setattr(step_rows, "MOST_ROWS", 10)  # as many steps as make rows of ten of them
    rows, full = thinned(100), touchdown.summary
    (notice,) = set(rows.summary.notices) - set(full.notices)
    assert_names(notice, "10 steps", "sampled", "record.every = 1")
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
    """The first impacts are enlarged with the values of every step."""
    (site, force), *_ = touched_sites(thin.signals).items()
    assert force.marked[1] == pytest.approx(touchdown.summary.averaged_contact_force[site])
    of_thin, of_full = (plots.figure(run.signals, "contact").axes for run in (thin, touchdown))
    assert of_thin[-1].get_xlim() == pytest.approx(of_full[-1].get_xlim())
    column = len(of_full) // 2
    curves = [axes[column].get_lines()[1].get_xydata() for axes in (of_thin, of_full)]
    begin, end = of_full[-1].get_xlim()
    drawn = [curve[(begin <= curve[:, 0]) & (curve[:, 0] <= end)] for curve in curves]
    assert drawn[0] == pytest.approx(drawn[1], rel=1e-6, abs=1e-9)
    insets = [
        [inset for axes in plots.figure(run.signals, "touchdown").axes for inset in axes.child_axes]
        for run in (thin, touchdown)
    ]
    curves = [[line.get_xydata() for line in inset.get_lines()] for (inset,) in insets]
    for curve, of_full in zip(*curves, strict=True):
        np.testing.assert_array_equal(curve, of_full)


@pytest.mark.parametrize("name", ["orbits", "displacement", "magnets", "turns"])
def test_figures_of_motion_and_magnets_draw_every_step(name, levitation):
    """A line through one sample per 37 steps, half a turn, would show no orbit."""
    thin = amb_cosim.run(load_scenario(str(LEVITATION)).changed(record={"every": 37}))
    drawn = [
        [line.get_xydata() for axes in plots.figure(run.signals, name).axes for line in axes.get_lines()]
        for run in (thin, levitation)
    ]
    for curve, of_full in zip(*drawn, strict=True):
        np.testing.assert_array_equal(curve, of_full)


def whirling(tmp_path, every, frequency, until="0.2 s", **record):
    """Run the levitated expander with a force that whirls at a frequency (Hz), backward if it is negative.

    The force grows with the square of the frequency, as inertia does, from 5 N at 100 Hz.
    """
    time = np.arange(0.0, 0.3, STEP)
    force = 5.0 * (frequency / 100.0) ** 2 * np.exp(2j * np.pi * frequency * time)
    rows = np.column_stack([time, force.real, force.imag])
    heading = "time (s),rotor_contact.turbine.f_x (N),rotor_contact.turbine.f_y (N)"
    np.savetxt(tmp_path / "force.csv", rows, delimiter=",", header=heading, comments="", fmt="%.9g")
    scenario = load_scenario(str(LEVITATION)).changed(
        event=[], profile=[{"file": str(tmp_path / "force.csv")}], record={"every": every, **record}
    )
    return amb_cosim.run(scenario, until=until)


def vibration(run):
    """Return frequency (Hz) and amplitude (m) of the strongest vibration at a bearing besides the synchronous one."""
    result = studies.waterfall(run, window="0.1 s", up_to="600 Hz").bearings["north"]
    return result.other_frequency, result.other_amplitude


@pytest.mark.parametrize("frequency", [-470.0, -120.0, 30.0, 120.0, 190.0, 290.0, 470.0])
def test_a_thinned_record_shows_whirl_at_its_frequency_and_in_its_direction(frequency, tmp_path):
    """Samples of every 10th and every 50th step fold at 1000 and 200 Hz."""
    full = whirling(tmp_path, 1, frequency)
    assert vibration(full)[0] == pytest.approx(frequency, abs=0.5)
    for every in (10, 50):
        run = whirling(tmp_path, every, frequency)
        assert vibration(run) == vibration(full)
        assert not studies.waterfall(run, window="0.1 s").folded


def earlier(run):
    """Return a record as an earlier version stored it: contact at every step, displacements only at the samples."""
    dataset = run.dataset
    dataset = dataset.drop_vars([name for name in dataset.data_vars if name.endswith((".x.steps", ".y.steps"))])
    return amb_cosim.Result(dataset, run.outcome)


def test_spectra_of_samples_begin_with_what_they_do_not_show(tmp_path):
    """290 Hz appear at 290 - 400 = -110 Hz in one sample per 50 steps of 50 us, which fold at 200 Hz."""
    run = earlier(whirling(tmp_path, 50, 290.0))
    result = studies.waterfall(run, window="0.1 s")
    assert result.bearings["north"].other_frequency == pytest.approx(-110.0, abs=0.5)
    assert_names(str(result).splitlines()[0], "50 steps", "200 Hz", "record.every = 1")
    with raises_naming(ValueError, "250 Hz", "200 Hz", "50 steps", "record.every = 1"):
        studies.waterfall(run, window="0.1 s", up_to="250 Hz")
    assert_names(run.summary.notices[-1], "50 steps", "sampled")


def test_samples_of_a_slow_whirl_are_still_usable(tmp_path):
    full, run = whirling(tmp_path, 1, 30.0), earlier(whirling(tmp_path, 50, 30.0))
    result = studies.waterfall(run, window="0.1 s", up_to="100 Hz").bearings["north"]
    assert result.other_frequency == pytest.approx(30.0, abs=0.5)
    assert result.other_amplitude == pytest.approx(vibration(full)[1], rel=0.02)


def test_spectra_of_a_long_run_say_that_their_rows_are_sampled(tmp_path, monkeypatch):
    """Rows of ten steps of 50 us fold at 1000 Hz; a last row of fewer steps is left out."""
    monkeypatch.setattr(step_rows, "MOST_ROWS", 10)
    run = whirling(tmp_path, 50, 290.0, until="0.20015 s")
    result = studies.waterfall(run, window="0.1 s", up_to="600 Hz")
    assert result.bearings["north"].other_frequency == pytest.approx(290.0, abs=0.5)
    assert_names(result.folded, "10 steps", "1000 Hz")


def test_a_measured_response_is_that_of_every_step(tmp_path):
    """Noise to 10 kHz: from samples of 2 kHz the response would be that of other frequencies."""
    force = np.random.default_rng(3).normal(size=2000)
    rows = np.column_stack([STEP * np.arange(len(force)), force])
    heading = "time (s),rotor_contact.turbine.f_x (N)"
    np.savetxt(tmp_path / "noise.csv", rows, delimiter=",", header=heading, comments="", fmt="%.9g")
    shaken = load_scenario(str(LEVITATION)).changed(event=[], profile=[{"file": str(tmp_path / "noise.csv")}])
    source, needed = "rotor_contact.turbine.f_x", ("rotor_contact.north.x", "rotor_contact.north_east")
    demand = "rolac_controller.north.u_x"  # which a thinned record has only at its samples
    responses = []
    for every in (1, 10):
        run = amb_cosim.run(shaken.changed(record={"every": every}), until="0.1 s")
        names = [source, demand, *needed]
        kept = [name for name in run.dataset.data_vars if name.removesuffix(".steps") in names]  # others take time
        save(run.dataset[kept], tmp_path / f"{every}.nc")
        record = read_run(tmp_path / f"{every}.nc", (source, *needed))
        assert not record.warning
        signals = {channel: values for channel, values in record.signals.items() if channel.name in (source, *needed)}
        responses.append(estimate(replace(record, signals=signals), [source]))
    assert [response.output.name for response in responses[0]] == sorted(needed)
    for full, thin in zip(*responses, strict=True):
        np.testing.assert_array_equal(thin.frequencies, full.frequencies)
        np.testing.assert_allclose(thin.values, full.values, rtol=1e-9)
    (warning,) = read_measured(tmp_path / "10.nc", {demand: "demand"}, [source]).warnings
    assert_names(warning, "10 steps", "1000 Hz", "record.every = 1")


def test_traces_draw_every_step_or_say_that_they_do_not(tmp_path):
    run = whirling(tmp_path, 50, 290.0, until="0.02 s")
    drawn = run.plot("north.x").axes[0]
    assert len(drawn.get_lines()[0].get_xdata()) == round(0.02 / STEP) + 1
    assert "50 steps" not in " ".join(text.get_text() for text in drawn.texts)
    sampled = run.plot("rolac_controller.north.u_x").axes[0]
    assert_names(" ".join(text.get_text() for text in sampled.texts), "50 steps")
