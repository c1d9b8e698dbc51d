"""Which scenarios a page has."""

from __future__ import annotations

from amb_cosim.live.rig import Rig, rig
from amb_cosim.scenario.scenario import load_scenario

# One for each thing to see: steps of unbalance, rolling, run-up, touchdown, faults, shock, another rotor.
SHOWN = (
    "fig4_9",
    "fig5_6_pid",
    "fig5_6",
    "fig6_13",
    "rolling_90",
    "run_up",
    "run_up_rolac",
    "drop",
    "drop_whirl",
    "relevitation",
    "one_axis_lost",
    "sensor_lost",
    "blade_loss",
    "base_shock",
    "compressor_levitated_touchdown",
)


def rigs_of(name: str, rotor: str | None = None, *, alone: bool = False) -> list[Rig]:
    """Return the rigs of a page: that of a scenario, then, unless `alone` or with another rotor, those of `SHOWN`.

    Parameters
    ----------
    name
        Name of a scenario that comes with the package, or scenario file.
    rotor
        Rotor that takes the place of the scenario's.

    Raises
    ------
    ValueError
        If the scenario, the rotor or a file is wrong, or a browser cannot run the scenario.
    """
    first = load_scenario(name)
    if rotor is not None:
        return [rig(first.model_copy(update={"rotor": rotor}))]
    others = () if alone else (load_scenario(other) for other in SHOWN if other != first.name)
    return [rig(first), *map(rig, others)]
