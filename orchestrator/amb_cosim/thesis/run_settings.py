"""Named quantities of what was run: its parameters, its factor, and what follows from them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from amb_cosim.cosim.signals import Signals
from rotor_analysis.campbell import campbell
from rotor_analysis.packaged_rotors import DEFAULT_ROTOR
from rotor_analysis.rotor_file import load_rotor
from rotor_analysis.supported_rotor import supported_rotor

FASTEST = 300.0  # rad/s, up to which critical speeds are looked for


def parameter(run: Signals, component: str, name: str) -> float | None:
    """Return a parameter of a component, in its unit."""
    found = json.loads(run.attrs["parameters"]).get(component, {}).get(name)
    return None if found is None else float(found)


def unbalance_factor(run: Signals) -> float:
    """Return the factor on the unbalances that the scenario states (1)."""
    return float(_scenario(run).get("unbalance_factor", 1.0))


def critical_speeds(run: Signals, count: int) -> list[float]:
    """Return the lowest critical speeds with forward whirl (rad/s) on bearings with the gains of axis x of MB1."""
    k_b, c_b = (parameter(run, "rolac_controller", f"mb1.{gain}_x") or 0.0 for gain in ("k_b", "c_b"))
    rotor = load_rotor(_scenario(run).get("rotor") or DEFAULT_ROTOR).on_equal_bearings(k_b, c_b)
    found = campbell(supported_rotor(rotor).model, np.linspace(0.0, FASTEST, 121), 2 * count)
    return [crossing.Omega for crossing in found.critical_speeds if crossing.whirl == "forward"][:count]


def _scenario(run: Signals) -> dict[str, Any]:
    """Return the scenario that was run, as data."""
    found: dict[str, Any] = json.loads(run.attrs["scenario_data"])
    return found


QUANTITIES: dict[str, tuple[Callable[..., Any], str]] = {
    "parameter": (parameter, ""),
    "unbalance_factor": (unbalance_factor, "1"),
    "critical_speeds": (critical_speeds, "rad/s"),
}
"""Each quantity with the unit of its number; that of a parameter is its own."""
