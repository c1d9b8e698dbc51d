"""Updates the table in docs/validation/contact_forces.md: `python -m tools.contact_forces [SCENARIO ...]`.

It runs the named scenarios, or all, and replaces their rows. Pages quote peaks from this table alone, which
`tests/docs/test_forces_on_pages.py` checks; slow tests run the scenarios.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "validation" / "contact_forces.md"
SCENARIOS = (
    "fig4_5",
    "fig4_7",
    "fig4_9",
    "fig4_12",
    "fig4_12_d2",
    "fig4_14",
    "fig4_18",
    "fig4_20",
    "fig5_5_pid",
    "fig5_6_pid",
    "fig5_6",
    "fig6_13_pid",
    "fig6_13",
    "fig6_15_pid",
    "fig6_15",
    "fig6_18_pid",
    "fig6_18",
    "drop",
    "drop_mount",
    "drop_whirl",
    "base_shock",
    "one_axis_lost",
    "amplifier_lost",
    "sensor_lost",
    "blade_loss",
    "nelson_mcvaugh_rub",
    "compressor_touchdown",
    "compressor_levitated_touchdown",
)
HEADING = (
    "| scenario | site | between impacts (N) | contact force (N) | largest impulse (N s) |\n" + "| --- " * 5 + "|\n"
)
ROW = re.compile(r"^\| `(\w+)` \| (\w+) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", re.MULTILINE)

Forces = dict[str, tuple[float, float, float]]


def forces_of(name: str) -> Forces:
    """Return peak force (N), force averaged over 1 ms (N) and largest impulse (N s) at each site that a run touches."""
    from amb_cosim.scenario.prepare_run import prepare_run
    from amb_cosim.scenario.scenario import load_scenario
    from amb_cosim.scenario.simulation import execute

    summary = execute(prepare_run(load_scenario(name))).summary
    averaged, impulse = summary.averaged_contact_force, summary.peak_impulse
    peaks = summary.peak_contact_force
    forces = {s: (peaks[s] or 0.0, averaged[s] or 0.0, impulse[s] or 0.0) for s in peaks}
    return {site: values for site, values in forces.items() if any(values)}


def read_page() -> dict[str, Forces]:
    """Return the forces on the page, by scenario."""
    forces: dict[str, Forces] = {}
    for name, site, peak, averaged, impulse in ROW.findall(PAGE.read_text(encoding="utf-8")):
        forces.setdefault(name, {})[site.lower()] = (float(peak), float(averaged), float(impulse))
    return forces


def table(scenarios: dict[str, Forces]) -> str:
    """Return the table in Markdown."""
    rows = (
        f"| `{name}` | {site.upper()} | {peak:.0f} | {averaged:.0f} | {impulse:.2f} |\n"
        for name, forces in scenarios.items()
        for site, (peak, averaged, impulse) in forces.items()
    )
    return HEADING + "".join(rows)


def main(*names: str) -> None:
    """Run the named scenarios, or all, and write the page; raises ValueError for a name not in `SCENARIOS`."""
    if unknown := sorted(set(names) - set(SCENARIOS)):
        raise ValueError(f"scenario {unknown[0]!r} is none of {', '.join(SCENARIOS)}")
    stored = read_page() if names else {}
    forces = {name: forces_of(name) if name in names or not names else stored.get(name, {}) for name in SCENARIOS}
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(HEADING)
    PAGE.write_text(before + table(forces) + "\n" + ROW.sub("", rest).lstrip("\n"), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
