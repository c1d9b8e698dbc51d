"""Studies of a rotor, its bearings and its control; packs may add theirs.

Each study is a function that returns a frozen dataclass. `print` shows its tables and `as_dict()` returns its data;
`figure` draws it and `save` writes both, where it has a figure. Arguments are numbers in SI units or texts with a unit,
such as "50 Hz".

    from amb_cosim import studies
    result = studies.campbell(up_to="100 Hz")
    result.critical_speeds[0].speed          # rad/s
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from amb_cosim.studies.figures import figure as figure
from amb_cosim.studies.figures import save as save

if TYPE_CHECKING:
    from amb_cosim.studies.bearing_axis import linearisation as linearisation
    from amb_cosim.studies.campbell_diagram import campbell as campbell
    from amb_cosim.studies.closed_loop_poles import poles as poles
    from amb_cosim.studies.contact_convergence import convergence as convergence
    from amb_cosim.studies.contact_traps import traps as traps
    from amb_cosim.studies.coupling_order import coupling as coupling
    from amb_cosim.studies.natural_modes import modes as modes
    from amb_cosim.studies.receptance_identification import identify as identify
    from amb_cosim.studies.rotor_layout import layout as layout
    from amb_cosim.studies.run_spectra import waterfall as waterfall
    from amb_cosim.studies.sensor_receptance import receptance as receptance
    from amb_cosim.studies.stability_margin import sensitivity as sensitivity
    from amb_cosim.studies.unbalance_over_speed import unbalance_response as unbalance_response

    STUDIES: dict[str, Study]  # those of this package and of the packs, by name


class Study(NamedTuple):
    """Module of a study's function, whole or relative to its package of studies, and one line about it."""

    module: str
    description: str

    def of(self, package: str) -> Study:
        """Return the study with its module's whole name."""
        return self._replace(module=package + self.module)


_OWN = {
    "layout": Study(".rotor_layout", "Show parts, mass and modes of a rotor, the plant's model of it, and a picture."),
    "campbell": Study(".campbell_diagram", "Draw the Campbell diagram of a rotor."),
    "modes": Study(".natural_modes", "List natural frequencies and draw mode shapes."),
    "unbalance_response": Study(".unbalance_over_speed", "Compute the unbalance response over speed."),
    "coupling": Study(
        ".coupling_order",
        "Compare orders and steps of the master. It compares orbit, outcome and cost of a scenario.",
    ),
    "convergence": Study(
        ".contact_convergence",
        "Check the convergence of contact forces. The study varies modes kept, mesh, substep and start.",
    ),
    "sensitivity": Study(
        ".stability_margin",
        "Compute the stability margin (ISO 14839-3). A co-simulation measures it, too.",
    ),
    "poles": Study(
        ".closed_loop_poles",
        "Draw the Campbell diagram of the levitated rotor.",
    ),
    "traps": Study(
        ".contact_traps",
        "Find states of lasting contact over the speed. Each has its stability and the force that frees it.",
    ),
    "robustness": Study(
        "amb_cosim.sweeps.robustness",  # stands on the sweeps, and so above this package
        "Check whether an outcome is robust. H is identified, gains and the like get 1 % more and less.",
    ),
    "linearisation": Study(
        ".bearing_axis",
        "Linearise an axis of a magnetic bearing. It prints K_s, K_i, load capacity, slew rate and bandwidth.",
    ),
    "receptance": Study(".sensor_receptance", "Compute synchronous responses to bearing forces."),
    "waterfall": Study(
        ".run_spectra",
        "Draw spectra over the time of a run or saved result.",
    ),
    "identify": Study(
        ".receptance_identification",
        "Identify receptances of the levitated rotor, as its controller does.",
    ),
}


def __getattr__(name: str) -> Any:
    """Import the function of a study when it is used."""
    if name == "STUDIES":
        return _all_studies()
    study = None if name.startswith("__") else study_of(name)
    if study is None:
        names = ", ".join(_all_studies())
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; the studies are {names}")
    return getattr(import_module(study.module, __name__), name)


def study_of(name: str) -> Study | None:
    """Return the study of a name, if there is one; packs are looked for only where it is none of this package."""
    return _OWN.get(name) or _all_studies().get(name)


def __dir__() -> list[str]:
    return sorted({"STUDIES", "Study", "figure", "save", *_all_studies()})


@cache
def _all_studies() -> dict[str, Study]:
    """Return the studies of this package and of the packs, by name."""
    from amb_files.packs import modules_of

    available = dict(_OWN)
    for pack, module in modules_of("studies").items():
        if twice := sorted(available.keys() & module.STUDIES):
            raise ValueError(f"pack {pack} has a study {twice[0]!r}, and there is another one; it must rename it")
        available |= {name: study.of(module.__name__) for name, study in module.STUDIES.items()}
    return available
