"""The scenarios of a page."""

from __future__ import annotations

from functools import cache

from amb_cosim.cosim.fmu.fmus import model_source
from amb_cosim.scenario.scenario import as_scenario, load_scenario
from amb_files.pack_file import pack_files
from amb_live.rig import Rig, rig


def rigs_of(name: str | None = None, rotor: str | None = None, *, alone: bool = False) -> list[Rig]:
    """Return the rigs of a page: the scenario and, unless `alone` is true or `rotor` is given, the packs' scenarios.

    Parameters
    ----------
    name
        Name of a packaged scenario, or scenario file; default: the packs' default scenario.
    rotor
        Rotor that replaces the scenario's.

    Raises
    ------
    ValueError
        If the scenario, the rotor or a file is invalid, or a browser cannot run the scenario.
    """
    first = as_scenario(name, rotor)
    alone = alone or rotor is not None
    others = [] if alone else [other for pack in pack_files().values() for other in pack.live if other != first.name]
    source = cache(model_source)  # computing the constants of a rotor takes long, and most scenarios share them
    return [rig(first, source), *(rig(load_scenario(other), source) for other in others)]
