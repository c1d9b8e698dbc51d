"""Print the benchmark as tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rich.table import Table

from amb_cosim.presentation.text_tables import labelled_table
from benchmarks import step_times
from benchmarks.measure import AT_MOST, RATIOS, REAL_TIME_FACTOR

RATIO_LABELS = {
    "native_over_floor": "native FMUs over one loop without FMI, fig4_9",
    "ecospy_over_native": "ecos over this master, native FMUs, rotor that rubs",
    "libcosimpy_over_native": "libcosim over this master, native FMUs, rotor that rubs",
    "ross_over_native": "ROSS run_rubbing, one site, over the native plant, two sites",
    "siconos_over_native": "Siconos, Moreau-Jean, two sites, over the native plant",
    "plain_over_compiled_python": "plain FMPy loop over compiled loop, FMUs of flavour python, fig4_9",
}
CANDIDATE_LABELS = {
    "native": "native FMUs, compiled loop",
    "native_plain": "native FMUs, plain loop",
    "python": "FMUs of flavour python, compiled loop",
    "python_plain": "FMUs of flavour python, plain loop",
    "floor": "baseline: kernels in one loop, no FMI",
}
GROWTH_LABELS = {
    "simulated_time": ("simulated_s", "seconds", "rotor that rubs: time (s) over simulated time (s)"),
    "sites": ("sites_in_contact", "step_s", "step of the plant (s) over sites in contact"),
    "variables": ("variables", "step_s", "step (s) over recorded variables"),
}


def as_tables(data: Mapping[str, Any]) -> list[Table | str]:
    """Return what `measure` returns as tables and lines of text."""
    single_steps = step_times.as_table(data["single_steps_us"])
    parts = [_ratios(data), _factors(data), _steps(data), single_steps, _growth(data)]
    where = data["environment"]
    machine = f"{where['processor']}, {where['cores']} cores, {where['system']}, Python {where['python']}"
    stiff = data["contact"]["cost_ratio_at_equal_accuracy"]
    return [
        *parts,
        "contact: no stiffness tried is as accurate as the constraint"
        if stiff is None
        else f"contact: at equal accuracy a stiff law costs {stiff:.1f} times what the constraint costs",
        *(f"{name}: {why}" for name, why in data["missing"].items()),
        f"{where['date']}, {machine}; medians of {data['rounds']} rounds, load {where['load_average']}",
    ]


def _ratios(data: Mapping[str, Any]) -> Table:
    table = labelled_table("Ratios of the time per step", "ratio", "median", "lowest", "highest", "aim")
    for name, (_, _, aim) in RATIOS.items():
        value, spread = data["ratios"][name], data["spread"][name]
        numbers = ["not measured", "", ""] if value is None else [f"{v:.2f}" for v in (value, *spread)]
        table.add_row(RATIO_LABELS[name], *numbers, f"{'<=' if name == AT_MOST else '>='} {aim:g}")
    if data["siconos_reduced_over_native"] is not None:
        table.add_row(
            "the same, Siconos with the reduced rotor", f"{data['siconos_reduced_over_native']:.2f}", "", "", ""
        )
    return table


def _factors(data: Mapping[str, Any]) -> Table:
    table = labelled_table("fig4_9 at 4 kHz", "", "times real time", "us for a step", "aim")
    for name, factor in data["real_time_factor"].items():
        if factor is not None:
            aim = f">= {REAL_TIME_FACTOR:g}" if name == "native" else ""
            table.add_row(CANDIDATE_LABELS[name], f"{factor:.1f}", f"{data['step_us'][name][0]:.2f}", aim)
    return table


def _steps(data: Mapping[str, Any]) -> Table:
    table = labelled_table("Parts of the time of a step, lowest of all rounds", "part", "us", "share of native")
    if data["floor_us"] is None:
        return table
    native, baseline, parts = data["step_us"]["native"][1], data["step_us"]["floor"][1], data["floor_us"]
    rest = {"rest of the baseline": baseline - sum(parts.values()), "FMI": native - baseline}
    for part, us in (parts | rest).items():
        table.add_row(part, f"{us:.2f}", f"{us / native:.0%}")
    return table


def _growth(data: Mapping[str, Any]) -> Table:
    table = labelled_table("Growth", "cost", "slope", "deviation from a line")
    for name, (_, _, title) in GROWTH_LABELS.items():
        line = data["linearity"][name]
        table.add_row(title, f"{line['slope']:.3g}", f"{line['largest_deviation']:.1%}")
    memory = data["memory"]
    if memory is not None:
        slope = f"{memory['slope'] / 1e6:.3g} MB, {memory['over_recorder']:.2f} of the numbers"
        table.add_row("peak memory over simulated time (s)", slope, f"{memory['largest_deviation']:.1%}")
    return table
