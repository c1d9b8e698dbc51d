"""Finds the variables that the names of a sweep vary, and names that vary the same variables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

from amb_cosim.cosim.system.assignments import Assignments
from amb_sweeps.axes import Axis, Vary, is_moment, names_of, read_variations
from amb_sweeps.worker import event_of

MOST_NAMED = 5  # variables in a message


def varied_variables(name: str, labels: Sequence[str], variables: Assignments) -> set[str]:
    """Return the variables of a name or pattern.

    Inputs of a shared signal are returned as the signal, and the cycle and the time of an event as one variable. A name
    that does not belong to a variable, such as a field of the scenario, is returned as it is.
    """
    label = event_of(labels, name)
    if is_moment(name):
        return {f"{name.partition('.')[0]}.cycle or .time"}
    try:
        matching = variables.matching(name.removeprefix(f"{label}."))
    except ValueError:  # reported where it is read
        return {name}
    signals = variables.system
    of_signals = (signals.signal(each) or signals.signal_of(each) for each in matching)
    targets = (each if signal is None else signal.name for each, signal in zip(matching, of_signals, strict=True))
    return {f"{label}.{target}" if label else target for target in targets}


def refuse_overlaps(axes: Iterable[Axis], labels: Sequence[str], variables: Assignments) -> None:
    """Refuse variables that two names of a sweep vary, because the second would override the first.

    The settings of one label of a table may overlap, because they are applied in order.

    Raises
    ------
    ValueError
        If two names share variables; the message states both names and these variables.
    """
    named = [(name, found) for axis in axes for name, found in _of_axis(axis, labels, variables)]
    for (first, one), (second, other) in combinations(named, 2):
        if shared := sorted(one & other):
            more = f" and {len(shared) - MOST_NAMED} more" * (len(shared) > MOST_NAMED)
            raise ValueError(
                f"{first} and {second} both vary {', '.join(shared[:MOST_NAMED])}{more}; vary each only once"
            )


def refuse_idle_settings(
    settings: Iterable[str], axes: Iterable[Axis], labels: Sequence[str], variables: Assignments
) -> None:
    """Refuse a setting that has no effect because all its variables are varied; variations by tables are ignored.

    Raises
    ------
    ValueError
        If a setting has no effect; the message states its name and the names that vary its variables.
    """
    columns = [column.name for axis in axes if not axis.alternatives for column in axis.columns]
    varied = {name: varied_variables(name, labels, variables) for name in columns}
    every: set[str] = set().union(*varied.values())
    for setting in settings:
        if (meant := varied_variables(setting, labels, variables)) <= every:
            names = ", ".join(name for name, found in varied.items() if found & meant)
            raise ValueError(f"{setting} is set, but it is varied by {names}, so the setting has no effect")


def not_replaced(ready: Vary, own: Vary, labels: Sequence[str], variables: Assignments) -> dict[str, object]:
    """Return the variations of a ready sweep, without variations of variables that the user varies."""
    if not own:
        return dict(ready)
    names = [name for variation in read_variations(own) for name in names_of(variation)]
    taken: set[str] = set().union(*(varied_variables(name, labels, variables) for name in names))

    def is_replaced(name: str) -> bool:
        parts = (part.strip() for part in name.split("&"))
        return set().union(*(varied_variables(part, labels, variables) for part in parts)) <= taken

    return {name: values for name, values in ready.items() if not is_replaced(name)}


def _of_axis(axis: Axis, labels: Sequence[str], variables: Assignments) -> list[tuple[str, set[str]]]:
    """Return the variables of each column of an axis, or of all settings of its alternatives."""
    if not axis.alternatives:
        return [(column.name, varied_variables(column.name, labels, variables)) for column in axis.columns]
    names = {name for settings in axis.alternatives for name in settings}
    return [(axis.name, set().union(*(varied_variables(name, labels, variables) for name in names)))]
