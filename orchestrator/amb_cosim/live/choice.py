"""Which scenarios a page has."""

from __future__ import annotations

from amb_cosim.live.rig import Rig, rig
from amb_cosim.scenario import Scenario, load_scenario
from amb_cosim.scenario_file import packaged_scenarios


def rigs_of(name: str, rotor: str | None = None, *, alone: bool = False) -> list[Rig]:
    """Return the rigs of a page: that of a scenario, then, unless `alone`, the scenarios of the same rotor.

    Parameters
    ----------
    name
        Name of a scenario that comes with the package, or scenario file.
    rotor
        Rotor that takes the place of the scenario's, and of the others' too.

    Raises
    ------
    ValueError
        If the scenario, the rotor or a file is wrong, or a browser cannot run the scenario.
    """
    first = _with_rotor(load_scenario(name), rotor)
    others = [] if alone else [load_scenario(other) for other in packaged_scenarios() if other != first.name]
    return [rig(first), *(rig(other) for other in others if _is_alike(other, first) and rotor is None)]


def _with_rotor(scenario: Scenario, rotor: str | None) -> Scenario:
    return scenario if rotor is None else scenario.model_copy(update={"rotor": rotor})


def _is_alike(scenario: Scenario, first: Scenario) -> bool:
    """Whether a scenario has the same FMUs in the same system."""
    fields = ("rotor", "receptances", "fmu", "coupling")
    return all(getattr(scenario, field) == getattr(first, field) for field in fields)
