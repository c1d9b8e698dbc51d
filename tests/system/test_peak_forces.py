"""The peak force of a run does not depend on its communication step; pages state the forces of runs."""

import re

import pytest

from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from amb_cosim.scenario.simulation import execute
from tools.contact_forces import PAGE, SCENARIOS, forces_of, read_page

pytestmark = pytest.mark.slow

NEWTON = {"rotor_contact.contact.impact_law": 1}
CHAOTIC = {"fig4_20": 0.16}  # relative scatter of the largest of all sites between processors
RUNS = {"drop": ({}, {}, 0.3), "fig4_12": ({"rotor": "bath_rig"}, NEWTON, 0.2)}
SHORT = {"drop": 0.6, "fig4_12": 0.9}  # the largest sample at RB2, over its peak


@pytest.mark.parametrize("name", RUNS)
def test_peak_forces_at_250_us_are_those_at_20_us(name):
    """At the retainers; a sample each 250 us misses more than half of the peak at RB2 of the drop.

    Magnet forces are held over a step. Where a blow follows them, as the first of `fig4_9`, its peak differs by 8 %.
    """
    changes, settings, until = RUNS[name]
    peaks, samples = [], []
    for step in ("250 us", "20 us"):
        scenario = load_scenario(name).changed(**changes, communication_step=step)
        result = execute(prepare_run(scenario, settings, until=until))
        peaks.append(result.summary.peak_contact_force)
        samples.append({site: float(result.signals[f"rotor_contact.{site}.f_n"].values.max()) for site in peaks[-1]})
    for site in ("rb1", "rb2"):
        assert peaks[0][site] > 1e3
        assert peaks[0][site] == pytest.approx(peaks[1][site], rel=0.03)
    assert samples[0]["rb2"] < SHORT[name] * peaks[0]["rb2"]


@pytest.mark.parametrize("name", [name for name in SCENARIOS if name.startswith(("fig", "drop", "nelson"))])
def test_forces_on_the_page_are_those_of_runs(name):
    """In a chaotic run only the largest force of all sites is compared: its last bounce on a site may stay out."""
    stated, computed = read_page()[name], forces_of(name)
    assert set(stated) == set(computed)
    if name in CHAOTIC:
        largest = [[max(values) for values in zip(*of_sites.values(), strict=True)] for of_sites in (stated, computed)]
        assert largest[1] == pytest.approx(largest[0], rel=CHAOTIC[name])
        return
    for site, values in computed.items():
        assert stated[site] == pytest.approx(values, rel=0.02, abs=2.0)


def test_page_lists_every_scenario_with_stated_forces():
    assert set(read_page()) == set(SCENARIOS)
    assert re.search(r"python -m tools\.contact_forces", PAGE.read_text(encoding="utf-8"))
