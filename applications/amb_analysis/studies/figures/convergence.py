"""Contact forces with other numbers of modes, other meshes, substeps and communication steps."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from amb_analysis.studies.contact_convergence import CONVERGED, ContactConvergence, ConvergenceRow
from amb_analysis.studies.convergence_runs import START
from amb_cosim.presentation.descriptions import name_label
from amb_cosim.presentation.style import BLUE, GREEN, ORANGE, PURPLE, YELLOW, StyledFigure, write_title
from amb_cosim.presentation.units import ShownUnit, force_unit

QUANTITIES = {"peak_force": "force between impacts", "mean_force": "mean over 1 ms", "peak_impulse": "largest impact"}
APART = 0.16  # distance of the sites of a run, over that of the runs
NAMED = 8  # most runs of a group whose names are written
SITE_STYLES = ((BLUE, "o"), (ORANGE, "s"), (GREEN, "^"), (PURPLE, "D"), (YELLOW, "v"))


def draw(result: ContactConvergence) -> Figure:
    """Draw each quantity at each site for every run, with a band of 5 % around the scenario's value."""
    scenario_rows = [row for row in result.rows if row.varied == "scenario"]
    groups = {
        varied: [scenario_rows[0], *(row for row in result.rows if row.varied == varied and row.start == 0)]
        for varied in ("modes", "mesh", "substep", "step")
    }
    groups = {"starts": scenario_rows} | {varied: rows for varied, rows in groups.items() if len(rows) > 1}
    if len(scenario_rows) == 1:
        del groups["starts"]
    sites = list(dict.fromkeys(site for row in result.rows for site in row.sites))
    figure = StyledFigure(figsize=(9.2, 7.0), layout="constrained")
    widths = [min(len(rows), NAMED) + 0.6 for rows in groups.values()]
    grid = figure.subplots(len(QUANTITIES), len(groups), sharey="row", sharex="col", squeeze=False, width_ratios=widths)
    for axes, varied in zip(grid[0], groups, strict=True):
        axes.set_title(varied)
    for (quantity, label), line in zip(QUANTITIES.items(), grid, strict=True):
        unit = _unit(quantity, result)
        for axes, rows in zip(line, groups.values(), strict=True):
            _draw_rows(axes, quantity, unit, rows, sites)
            if len(rows) <= NAMED:
                axes.set_xticks(range(len(rows)), [_name(row) for row in rows], rotation=60, ha="right")
        line[0].set_ylabel(f"{label} ({unit.label})")
        line[0].set_ylim(0.0, 1.05 * line[0].get_ylim()[1])
    if sites:
        figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=len(SITE_STYLES))
    write_title(
        figure,
        f"{result.scenario} with {result.rotor}: band of {100.0 * CONVERGED:g} % around the scenario's value; "
        "hollow: another outcome" + f"\nstart k: clearances multiplied by 1 + {START:g} k" * ("starts" in groups),
    )
    return figure


def _name(row: ConvergenceRow) -> str:
    return f"start {row.start}" if row.start else row.label


def _unit(quantity: str, result: ContactConvergence) -> ShownUnit:
    """Return the unit of a quantity: a unit of force that suits the largest force, or N s."""
    if quantity == "peak_impulse":
        return ShownUnit("N s", 1.0)
    return force_unit(max((getattr(site, quantity) for row in result.rows for site in row.sites.values()), default=0.0))


def _draw_rows(axes: Axes, quantity: str, unit: ShownUnit, rows: list[ConvergenceRow], sites: list[str]) -> None:
    """Draw a quantity at each site for all runs, with the sites beside each other."""
    for n, (site, (colour, marker)) in enumerate(zip(sites, SITE_STYLES, strict=False)):
        beside = APART * (n - 0.5 * (len(sites) - 1))
        reference = rows[0].sites.get(site)
        if reference is not None:
            value = getattr(reference, quantity) / unit.size
            axes.axhspan(value * (1.0 - CONVERGED), value * (1.0 + CONVERGED), color=colour, alpha=0.12, lw=0)
        for k, row in enumerate(rows):
            if site in row.sites:
                face = colour if row.recovery == rows[0].recovery else "white"
                label = name_label(site) if k == 0 else None
                value = getattr(row.sites[site], quantity) / unit.size
                axes.plot(k + beside, value, marker, ms=5, color=colour, markerfacecolor=face, label=label, ls="none")
    axes.set_xlim(-0.5, len(rows) - 0.5)
    axes.grid(color="0.9", lw=0.5)
