"""The largest contact force is one number wherever it is shown: the largest 1 ms mean of the record, with impacts."""

import io

import numpy as np
import pytest
from rich.console import Console

import amb_cosim
from amb_cosim import studies
from amb_cosim.presentation.text_tables import print_parts
from amb_sweeps.summary import summarise_sweep
from source_check import run_quantities

UNTIL = 0.3  # s: the impacts of fig4_9 are over


@pytest.fixture(scope="module")
def result():
    return amb_cosim.run("fig4_9", until=UNTIL)


@pytest.fixture(scope="module")
def force(result):
    """The impulse of the record in each window of 1 ms, over 1 ms: at RB1, with impacts (N)."""
    data = result.dataset
    time, mean = data["time"].values, data["rotor_contact.rb1.f_n_mean"].values
    impulse = np.append(0.0, np.cumsum(mean[1:] * np.diff(time)))
    return ((impulse - np.interp(time - 1e-3, time, impulse)) / 1e-3).max()


def printed(parts):
    text = io.StringIO()
    print_parts(parts, Console(file=text, width=250))
    return text.getvalue()


def test_impacts_make_it_larger_than_the_force_between_them(result, force):
    between = result.dataset["rotor_contact.rb1.f_n_peak"].values.max()
    assert force > 1.5 * between
    assert result.summary.peak_contact_force["rb1"] == pytest.approx(between)


def test_run_compare_and_report_state_it(result, force):
    assert result.summary.averaged_contact_force["rb1"] == pytest.approx(force)
    assert dict(result.summary.verdict.facts)["largest contact force"].startswith(f"{1e-3 * force:.2f} kN at RB1")
    assert run_quantities.contact_force(result.signals, "rb1") == pytest.approx(force)
    text = printed(amb_cosim.compare("fig4_9", "fig4_9", until=UNTIL).text(True))
    fact, row = (line for line in text.splitlines() if "largest contact force" in line and "rb2" not in line)
    assert f"{1e-3 * force:.2f} kN" in fact
    assert f"{force:.4g}" in row


def test_robustness_and_sweep_state_it(force, tmp_path):
    swept = amb_cosim.sweep(
        "fig4_9", vary={"rotor_contact.rb1.clearance": ["0.75 mm"]}, until=UNTIL, output=tmp_path / "s"
    )
    assert float(swept.dataset["averaged_contact_force.rb1"].max()) == pytest.approx(force)
    (line, *_) = summarise_sweep(swept.dataset, swept.design, swept.folder, "")
    assert f"largest contact force (1 ms mean with impacts) up to {1e-3 * force:.4g}" in line


@pytest.mark.slow
def test_robustness_states_it_for_the_unchanged_scenario():
    row = studies.robustness("fig4_9", progress=False).rows[0]
    whole = amb_cosim.run("fig4_9").summary.averaged_contact_force
    assert row.contact_force == pytest.approx({site: force for site, force in whole.items() if force})
