"""Words of runs of loops that are drawn at random; the truth is the motion after a kick, two seconds later.

A run without the kick is subtracted, so that neither weight nor unbalance hides slow growth. Seeds 0 to 199 were run:
6,200 words, of which 7 % are `undecided`.
"""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import amb_cosim
from amb_cosim.results.loop_stability import stability_of_loop
from amb_cosim.results.summary import summarise
from amb_cosim.scenario.scenario import Scenario

pytestmark = pytest.mark.slow

SLENDER = Path(__file__).parent / "slender"
SEEDS = (*range(12), 57, 196)  # the last two are stable, but their unbalance makes them touch
LONG, SHORT = 2.0, 0.25  # s, of the run that shows the truth, and of the run that is cut
FIRST, N_ENDS = 0.004, 31  # s, and number of ends
PLACES = [f"rotor_contact.{place}.{axis}" for place in ("left", "right") for axis in "xy"]


def drawn(seed: int, folder: Path) -> tuple[Scenario, Scenario, float]:
    """Return a scenario without and with a kick, and its period (s); half of the gains are near the stability limit."""
    g = np.random.Generator(np.random.Philox(seed))
    kd = g.uniform(-0.3, 1.2) if g.random() < 0.5 else g.uniform(0.3, 0.5)
    kp = 1762.5 * g.uniform(0.8, 1.4)
    ki = 0.0 if g.random() < 0.4 else 10.0 ** g.uniform(1.0, 3.3)
    rpm = 10.0 ** g.uniform(2.5, 4.8)
    unbalance = 0.0 if g.random() < 0.3 else g.uniform(0.0, 1.0)
    gravity = 9.81 if g.random() < 0.4 else 0.0
    law = "linear" if g.random() < 0.6 else "nonlinear"
    kick, delay, axis = 10.0 ** g.uniform(-3.0, -0.5), int(g.integers(0, 3)), "xy"[int(g.integers(2))]
    gains = f'kp = "{kp} A/m", kd = "{kd} A.s/m"' + (f', ki = "{ki} A/(m.s)"' if ki else "")
    file = folder / f"{seed}.toml"
    text = (SLENDER / "lead.toml").read_text().replace("delay = 0", f"delay = {delay}")
    file.write_text(text.replace('kp = "1762.5 A/m", kd = "1.1 A.s/m"', gains))
    quiet = Scenario.load(SLENDER / "levitation.toml").changed(
        fmu={"rolac_controller": str(file)},
        Omega=f"{rpm} rpm",
        gravity=f"{gravity} m/s2",
        parameters={"amb_actuator": {"force_law": law}},
        inputs={"rotor_contact": {"centre.u": f"{unbalance} g.mm"}},
    )
    kicks = ((0, kick, "kick"), ("1 ms", 0.0, "end_of_kick"))
    event = [{"label": at, "time": t, "set": {"rotor_contact": {f"centre.f_{axis}": f}}} for t, f, at in kicks]
    return quiet, quiet.changed(event=event), 60.0 / rpm


def run(scenario: Scenario, until: float):
    return amb_cosim.run(scenario, until=until, progress=False)


def allowed_words(quiet: Scenario, kicked: Scenario) -> set[str]:
    """Return the true words of runs before any contact.

    The loop is unstable if the motion due to the kick is larger in the last half second than before. A rotor that
    touches later is never levitated, whether or not its loop is stable.
    """
    kicked_run, quiet_run = run(kicked, LONG), run(quiet, LONG)
    if kicked_run.summary.first_contact is not None:
        return {"unstable", "undecided"}
    time = kicked_run.dataset["time"].values
    square = sum((kicked_run.dataset[name].values - quiet_run.dataset[name].values) ** 2 for name in PLACES)
    early, late = (np.mean(square[(time >= begin) & (time < begin + 0.5)]) for begin in (1.0, 1.5))
    return {"unstable"} if late > early else {"levitated", "undecided"}


def words(kicked: Scenario, period: float) -> Counter[str]:
    """Return how often each word occurs at the ends of runs that end before any contact."""
    end, result = SHORT, run(kicked, SHORT)
    if result.summary.first_contact is not None:
        end = 0.9 * result.summary.first_contact * period
        result = run(kicked, end)
    assert stability_of_loop(result.dataset) is not None
    time, counted = result.dataset["time"].values, Counter[str]()
    for until in np.geomspace(FIRST, SHORT, N_ENDS):
        if until <= end:
            dataset = result.dataset.isel(time=time <= until).assign_attrs(simulated_s=until)
            counted[summarise(dataset).verdict.word] += 1
    return counted


@pytest.mark.parametrize("seed", SEEDS)
def test_no_end_of_a_loop_has_a_false_word(seed, tmp_path):
    quiet, kicked, period = drawn(seed, tmp_path)
    counted = words(kicked, period)
    assert counted.keys() <= allowed_words(quiet, kicked)
    if "levitated" in counted:
        assert counted["undecided"] <= N_ENDS / 2.0
