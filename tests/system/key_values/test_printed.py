"""The numbers of the printed summary, read from its text, against the record of every step."""

import io
import re

import numpy as np
import pytest
from rich.console import Console
from waveforms import heat_of, mean_over_a_millisecond

from amb_cosim.results.summary_table import print_summary

DIGITS = 6e-3  # of a number that is printed with three digits
SIZES = {"kN": 1e3, "N": 1.0, "µm": 1e-6, "mm": 1e-3, "J": 1.0, "A": 1.0, "s": 1.0, "%": 0.01}
MU_0 = 4e-7 * np.pi


def printed(record):
    """Texts by label."""
    text = io.StringIO()
    print_summary(record.result.summary, Console(file=text, width=250), whole=True)
    rows = re.findall(r"^(\S.*?) {2,}(\S.*?) *$", text.getvalue(), re.MULTILINE)
    return dict(rows)


def numbers(text):
    """Numbers with their units, in SI units."""
    return [
        float(value) * SIZES[unit] for value, unit in re.findall(r"(-?[\d.]+(?:e-?\d+)?) (kN|N|µm|mm|J|A|s|%)", text)
    ]


def test_margin_to_the_clearance(record):
    text = printed(record).get("margin to the clearance")
    word = record.result.summary.verdict.word
    assert (text is None) == (word not in ("levitated", "recovered", "unstable", "free"))
    if text is None:
        return
    within = record.cycle >= (record.begin if word == "levitated" else record.cycle[-1] - 1.0)
    orbits = {}
    for site in record.places["sites"]:
        if record.of_plant[f"{site}.enabled"]:
            orbits[site] = np.abs(record.motion(site))[within].max(), record.of_plant[f"{site}.clearance"]
    site = max(orbits, key=lambda name: orbits[name][0] / orbits[name][1])
    orbit, clearance = orbits[site]
    assert f"at {site.upper()}" in text
    assert numbers(text) == pytest.approx([1.0 - orbit / clearance, orbit, clearance], rel=DIGITS)


def test_largest_contact_force(record):
    forces = {site: mean_over_a_millisecond(record, site) for site in record.contacts if record[f"{site}.mode"].any()}
    text = printed(record).get("largest contact force")
    assert (text is None) == (not forces)
    if text is not None:
        site = max(forces, key=lambda name: forces[name])
        assert site in text.lower()
        assert numbers(text)[0] == pytest.approx(forces[site], rel=DIGITS)


def test_time_in_contact(record):
    """Each step by its end: in all, and at each site."""
    closed = {site: record[f"{site}.mode"][1:] > 0 for site in record.contacts}
    steps = np.diff(record.t)
    text = printed(record).get("time in contact")
    if not any(of.any() for of in closed.values()):
        assert text is None
        return
    touched = steps[np.any([*closed.values(), record["contact_state"][1:] > 0], axis=0)].sum()
    assert numbers(text)[:3] == pytest.approx([touched, steps.sum(), touched / steps.sum()], rel=DIGITS)
    of_sites = dict(re.findall(r"(\w+) ([\d.]+) s(?=[,;])", text))
    for site, of in closed.items():
        if of.any():
            assert float(of_sites[site.upper() if site.upper() in of_sites else site]) == pytest.approx(
                steps[of].sum(), rel=DIGITS
            )


def uses(record):
    """The largest share of a limit, its value and limit: of a current that flows, of a demand, and of a force."""
    p, currents, demands, forces = record.parameters.get("amb_actuator", {}), [], [], []
    of_law = record.parameters.get("rolac_controller", {})
    for magnet in record.places["magnetic"]:
        for axis in "xy" if f"{magnet}.turns_x" in p else "z":
            of = {name: p[f"{magnet}.{name}_{axis}"] for name in (
                "turns", "pole_area", "gap", "half_angle", "bias_current", "static_current", "current_limit", "b_sat"
            )}  # fmt: skip
            on = record.signals.get(f"amb_actuator.{magnet}.amplifier_off_{axis}", np.zeros(len(record.t))) == 0.0
            upper, lower = (record.signals[f"amb_actuator.{magnet}.i_{pair}_{axis}"] for pair in ("upper", "lower"))
            i = 0.5 * (upper - lower - of["static_current"])
            demand = record.signals[f"rolac_controller.{magnet}.i_{axis}"]
            f = record.signals[f"amb_actuator.{magnet}.f_{axis}"]
            above, below, most = of["static_current"] + of["bias_current"], of["bias_current"], of["current_limit"]
            lowest, highest = max(-above, below - most), min(most - above, below)
            if f"{magnet}.i_min_{axis}" in of_law:
                lowest = max(lowest, of_law[f"{magnet}.i_min_{axis}"])
                highest = min(highest, of_law[f"{magnet}.i_max_{axis}"])
            per_ampere = MU_0 * of["turns"] / of["gap"]
            area = of["pole_area"] * np.cos(of["half_angle"]) / MU_0
            flux = min(of["b_sat"], per_ampere * most)
            static = 0.0 if p["total_force"] else area * per_ampere**2 * (above**2 - below**2)
            for values, low, high, found in (
                (i, lowest, highest, currents),
                (demand, lowest, highest, demands),
                (f, -area * flux**2 - static, area * flux**2 - static, forces),
            ):
                for value in values[on & record.after]:
                    found.append(
                        (value / (high if value > 0.0 else low), abs(value), abs(high if value > 0.0 else low))
                    )
    return [max(found, default=None) for found in (currents, demands, forces)]


def test_largest_current_and_force_of_the_magnets_as_shares_of_their_limits(record):
    rows, (current, demand, force) = printed(record), uses(record)
    for label, use in (("largest control current", current), ("largest magnet force", force)):
        assert (label in rows) == (use is not None), label
        if use is not None:
            assert numbers(rows[label]) == pytest.approx(use, rel=DIGITS), label
    assert ("largest demanded current" in rows) == (demand is not None and abs(demand[0] - current[0]) > 0.01)
    if "largest demanded current" in rows:
        assert numbers(rows["largest demanded current"]) == pytest.approx(demand, rel=DIGITS)


def test_heat_and_temperature_of_a_landing(record):
    rows, fall = printed(record), record.given["touchdown"]
    if "heat in contact" not in rows:
        assert fall is None or record.given["recovery"] != "landed"
        return
    heats = {site: heat_of(record, site) for site in fall["retainers"]}
    most = max(heats, key=lambda site: heats[site])
    assert numbers(rows["heat in contact"])[0] == pytest.approx(sum(heats.values()), rel=DIGITS)
    assert most in rows["heat in contact"].lower()
    temperatures = [item["temperature_K"] for item in fall["retainers"].values()]
    if not any(temperatures):
        assert "not computed" in rows["highest temperature"]
        return
    hottest = max(filter(None, temperatures))
    shown = float(re.match(r"[\d.]+", rows["highest temperature"])[0])
    assert shown == pytest.approx(hottest - 273.15, abs=6e-3)
