"""Checks the variations of a sweep, value by value, before any run."""

from __future__ import annotations

from amb_cosim.cosim.system.values import plain_number
from amb_cosim.presentation.descriptions import common_words
from amb_cosim.scenario.far_values import StatedValues
from amb_cosim.scenario.scenario import UNBALANCE
from amb_sweeps.overlaps import refuse_idle_settings, refuse_overlaps
from amb_sweeps.panels import first_words
from amb_sweeps.sampling import SamplePlan
from amb_sweeps.worker import Runner, Task, event_of

FACTOR = "unbalance_factor"


def check_points(task: Task, design: SamplePlan) -> tuple[dict[str, str], dict[str, str], dict[str, str]]:
    """Check each value of a sweep; return the GUIDs of its FMUs and the units and descriptions of its variations.

    FMUs are built if necessary.

    Raises
    ------
    ValueError
        If a name or a value is invalid, two names vary the same variable, a setting has no effect, or a number without
        a unit is far from the scenario's value.
    """
    runner, labels = Runner(task), task.scenario.labels
    guids: dict[str, str] = {}
    units: dict[str, str] = {}
    descriptions: dict[str, str] = {}
    sampled = design.sampling != "grid" and len(design.axes) == 1
    for point in design.extremes() if sampled else design.corners():
        settings = design.settings(point)
        prepared = runner.plan(settings)
        variables = prepared.assembly.assignments()
        refuse_overlaps(design.axes, prepared.scenario.labels, variables)
        refuse_idle_settings(task.settings, design.axes, prepared.scenario.labels, variables)
        if not set(guids) >= {fmu.path.stem for fmu in prepared.fmus.values()}:
            guids |= {prepared.fmus[c].path.stem: interface.guid for c, interface in prepared.interfaces.items()}
        stated = StatedValues(task.scenario, task.settings, variables)
        for name, value in settings.items():
            label = event_of(labels, name)
            ports = stated.ports(name.removeprefix(f"{label}."))
            if ports and ports[0].unit:
                units.setdefault(name, ports[0].unit)
                if (number := plain_number(value)) is not None:
                    stated.refuse_far(name, number, label)
            if common := common_words([port.description for port in ports]):
                since = f", from the {label.replace('_', ' ')} on" if label else ""
                factor = prepared.scenario.unbalance_factor
                if label and ports[0].unit == UNBALANCE and factor != 1.0:
                    since += f", before the factor {factor:g}" if FACTOR not in settings else ", before the factor"
                descriptions.setdefault(name, first_words(common) + since if label else common)
    return guids, units, descriptions
