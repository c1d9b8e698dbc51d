"""Checks the attributes of a result file for wrong types, missing attributes and contradictions.

A file from elsewhere may lack an attribute, or contain one that has another type or excessively nested JSON. Such a
file is refused when it is read, so that summaries and figures can rely on the attributes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, Json, ValidationError, with_config

from amb_cosim.cosim.choices import Settling
from amb_cosim.cosim.record.signals import Signals
from amb_cosim.cosim.record.warnings import WarningRecord
from amb_cosim.cosim.run.recording import Status
from amb_cosim.results.component_names import PLANT
from amb_cosim.results.places import RotorPlaces, places

Positive = Annotated[FiniteFloat, Field(gt=0.0)]
Duration = Annotated[FiniteFloat, Field(ge=0.0)]
UNITS = {"x": "m", "y": "m", "f_n": "N", "f_n_peak": "N", "f_n_mean": "N", "impulse": "N.s", "whirl_speed": "rad/s"}
Texts = Json[list[str]]
Tables = Json[dict[str, dict[str, Any]]]


@with_config(ConfigDict(extra="forbid"))
@dataclass(frozen=True)
class StoredWarning(WarningRecord):
    """A warning in a file; it has no fields other than these."""


class RunAttributes(BaseModel):
    """Attributes of any run; those of a scenario's run are checked if they are present."""

    model_config = ConfigDict(strict=True, extra="allow")

    outcome: Json[tuple[Status, FiniteFloat, str | None, str]]
    system: str = ""
    flavour: str = ""
    settling: Settling = "simulated"
    failure: str = ""
    stopped: str = ""
    communication_step_s: Positive = 1.0
    settling_s: Duration = 0.0
    simulated_s: Duration = 0.0
    wall_s: Duration = 0.0
    completed: int = 1
    notices: Texts = []
    warnings: Json[list[StoredWarning]] = []
    parameters: Tables = {}
    period_s: Positive = 1.0
    speed_rad_s: FiniteFloat = 0.0
    speed_profile: Json[list[tuple[FiniteFloat, FiniteFloat]]] = []
    last_change_cycle: FiniteFloat = 0.0
    disturbance_cycle: FiniteFloat = 0.0
    relief_cycle: FiniteFloat = 0.0
    disturbance_label: str = ""
    relief_label: str = ""
    sources: Texts = []
    plot_cycles: tuple[FiniteFloat, FiniteFloat] = (0.0, 0.0)
    plot_figures: Texts = []
    description: str = ""
    scenario_data: Json[dict[str, Any]] = {}


class ScenarioAttributes(RunAttributes):
    """Attributes of a scenario's run, which its summary and figures require."""

    scenario: str
    flavour: str
    places: Json[RotorPlaces]
    settling_s: Duration
    simulated_s: Duration
    wall_s: Duration
    completed: int
    period_s: Positive
    speed_rad_s: FiniteFloat


def check_signals(dataset: Signals) -> None:
    """Raise ValueError if an attribute is missing, has another type, or contradicts other attributes or the times.

    Parameters
    ----------
    dataset
        The record of a run; its cycles, places and units are checked if it is a run of a scenario.
    """
    check_attributes(dataset.attrs)
    if "scenario" not in dataset.attrs:
        return
    time, period = dataset["time"].values, float(dataset.attrs["period_s"])
    if "cycle" not in dataset or not np.allclose(dataset["cycle"].values * period, time, 1e-9, 1e-9 * period):
        raise ValueError(f"its cycles do not match its times; a cycle takes {period:g} s")
    _check_places(places(dataset))
    for site in places(dataset).sites:
        for name, unit in UNITS.items():
            label = f"{PLANT}.{site}.{name}"
            stated = dataset[label].attrs.get("units", "") if label in dataset else unit
            if stated != unit:
                raise ValueError(f"units of {label} = {stated!r} is not allowed; it must be {unit}")


def _check_places(stated: RotorPlaces) -> None:
    """Raise ValueError if places name sites or bearings that do not exist."""
    named = {
        "sites": [*filter(None, stated.bearings.values()), *stated.measured, *stated.apart, *stated.stators],
        "bearings": [*stated.magnetic, *stated.stators.values(), *stated.second.values()],
    }
    named["sites"] += [*stated.second, *stated.z, *filter(None, stated.faces.values())]
    allowed = {"sites": stated.sites, "bearings": stated.magnets}
    for kind, names in named.items():
        if unknown := sorted(set(names) - {*allowed[kind]}):
            raise ValueError(f"its attribute 'places' is not allowed: {unknown[0]!r} is not among its {kind}")


def check_attributes(attributes: Mapping[Any, Any]) -> None:
    """Raise ValueError if an attribute of a run is missing or has another type; the message names the first one."""
    form = ScenarioAttributes if "scenario" in attributes else RunAttributes
    try:
        form.model_validate({str(name): _plain(value) for name, value in attributes.items()})
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        name, *inner = map(str, first["loc"])
        where = f" ({'.'.join(inner)})" if inner else ""
        raise ValueError(f"its attribute {name} is not allowed{where}: {first['msg'].lower()}") from None


def _plain(value: Any) -> Any:
    """Convert a NumPy number or text to a Python one, and an array to a tuple."""
    if isinstance(value, np.ndarray):
        return tuple(value.tolist()) if value.ndim else value.item()
    return value.item() if isinstance(value, np.generic) else value
