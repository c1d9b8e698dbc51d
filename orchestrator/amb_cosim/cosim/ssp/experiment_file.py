"""Extra files of an archive for what SSP cannot express: the experiment in the form of a system file, and notes.

SSP 1.0 has only a start and a stop time. Events, profiles, stop conditions and recorded variables are in the file
`EXPERIMENT`, which `load_ssp` reads. The file `NOTES` describes them in words.
"""

from __future__ import annotations

from typing import Any

import tomli_w

from amb_cosim.cosim.ssp.structure import Described

EXPERIMENT, NOTES = "extra/amb-cosim/experiment.toml", "extra/amb-cosim/README.md"


def experiment_table(run: Described) -> bytes:
    """Return the table `experiment` of a system file as TOML, with times on the grid of the communication step."""
    plan, h = run.plan, run.plan.step_size
    table: dict[str, Any] = {
        "communication_step": h,
        "start_time": plan.time(plan.first),
        "stop_time": plan.time(plan.last),
        "inputs": {
            name: _typed(run, name, value)
            for name, value in plan.inputs.items()
            if run.port(name).causality == "input"  # tunable parameters have theirs in the archive's bindings
        },
        "event": [{"time": plan.time(n), "set": {name: _typed(run, name, value)}} for n, name, value in plan.events],
        "profile": [
            {"variable": r.variable, "points": [[plan.time(n), value] for n, value in r.points]}
            | ({"slope": r.slope} if r.slope is not None else {})
            for r in plan.ramps
        ],
        "stop": [
            {
                "variable": stop.signal,
                "above" if stop.above else "below": stop.limit,
                "from_time": plan.time(stop.first),
                "hold_time": stop.hold * h,
            }
            for stop in plan.stops
        ],
        "record": {
            "variables": list(plan.recorded),
            "every": plan.record_every,
            "settling": plan.record_from == plan.first,
        },
    }
    return tomli_w.dumps({key: value for key, value in table.items() if value != []}).encode()


def notes(run: Described, has_start_values: bool) -> bytes:
    """Return the notes for users of other tools."""
    plan, h = run.plan, run.plan.step_size
    order = ", ".join(c.name for c in plan.system.components)
    sequence = {
        "gauss_seidel": f"Sequential (Gauss-Seidel): step the components in the order {order}; each reads the outputs "
        "of earlier components at the end of their step.",
        "jacobi": "Parallel (Jacobi): all components read the outputs of the others at the beginning of the step.",
        "iterative": "Iterative: steps are repeated from saved states until inputs agree with the outputs at the end "
        f"of the step. A tool that cannot repeat steps can step the components one after another, in the order "
        f"{order}.",
    }[plan.system.coupling]
    parts = [
        f"# {run.name}",
        plan.system.description,
        f"Written by {run.generator}. SSP 1.0 cannot express the following settings, so SystemStructure.ssd lacks "
        f"them or has them only in annotations.",
        "## Order and step",
        f"{sequence} Communication step: {h:g} s, from {plan.time(plan.first):.9g} s to {plan.time(plan.last):.9g} s.",
    ]
    slow = [f"`{c.name}`: {c.every} communication steps" for c in plan.system.components if c.every > 1]
    if slow:
        parts.append("Components with their own steps: " + "; ".join(slow) + ".")
    if has_start_values:
        parts.append(
            "Parameters and initial inputs are also start values of the FMUs: a tool that ignores parameter bindings "
            "obtains the same results."
        )
    else:
        parts.append("Parameters and initial inputs are only in the parameter bindings, which a tool must apply.")
    rows = [
        f"| {name} | {', '.join(f'`{end}`' for end in ends)} | {_initial_value(run, name)} |"
        for name, ends in run.changing.items()
    ]
    if rows:
        how = (
            "They are connectors of the system"
            if run.connectors
            else "They have no connectors; their initial values are the start values of the inputs"
        )
        parts.append(
            f"## Signals\n\nSignals that set several inputs, or change during the run. {how}.\n\n"
            "| signal | inputs | initial value |\n| --- | --- | --- |\n" + "\n".join(rows)
        )
    events = [
        f"| {plan.time(n):.9g} | {name} | {_typed(run, name, value)!r} |" for n, name, value in sorted(plan.events)
    ]
    events += [
        f"| {plan.time(n):.9g} | {r.variable} (linear between points) | {v!r} |"
        for r in plan.ramps
        for n, v in r.points
    ]
    if events:
        table = "| time in s | input | value |\n| --- | --- | --- |\n" + "\n".join(events)
        parts.append(
            f"## Events\n\nInputs change at these times; set them before the step that starts at that time.\n\n{table}"
        )
    if plan.stops:
        parts.append("## Stop conditions\n\n" + "\n".join(f"- {stop.text}" for stop in plan.stops))
    return ("\n\n".join(part for part in parts if part) + "\n").encode()


def _initial_value(run: Described, name: str) -> str:
    value = run.plan.inputs.get(name)
    return repr(_typed(run, name, (run.port(name).start or 0.0) if value is None else value))


def _typed(run: Described, name: str, value: float) -> float | int | bool:
    """Return a value converted to the type of its variable."""
    kind = run.port(name).type
    return float(value) if kind == "Real" else bool(value) if kind == "Boolean" else int(value)
