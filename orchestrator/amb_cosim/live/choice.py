"""Which scenarios a page has."""

from __future__ import annotations

from functools import cache

from amb_cosim.cosim.fmu.fmus import model_source
from amb_cosim.live.rig import Rig, rig
from amb_cosim.scenario.scenario import given_scenario, load_scenario
from amb_files.pack_file import pack_files


def rigs_of(name: str | None = None, rotor: str | None = None, *, alone: bool = False) -> list[Rig]:
    """Return the rigs of a page: that of a scenario, then, unless `alone` or with another rotor, those that packs show.

    Parameters
    ----------
    name
        Name of a scenario of a pack, or scenario file; the packs' default without.
    rotor
        Rotor that takes the place of the scenario's.

    Raises
    ------
    ValueError
        If the scenario, the rotor or a file is wrong, or a browser cannot run the scenario.
    """
    first = given_scenario(name, rotor)
    alone = alone or rotor is not None
    others = [] if alone else [other for pack in pack_files().values() for other in pack.live if other != first.name]
    source = cache(model_source)  # the constants of a rotor take long, and most scenarios have the same
    return [rig(first, source), *(rig(load_scenario(other), source) for other in others)]
