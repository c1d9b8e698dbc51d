"""Studies of a rotor, its bearings and its control; other applications and packs can add more.

Each study is a function that returns a frozen dataclass. `print` shows its tables, and `as_dict()` returns its data. If
the study has a figure, `figure` draws it, and `save` writes the data and the figure. Arguments are numbers in SI units,
or strings with a unit, such as "50 Hz".

    from amb_analysis import studies
    result = studies.campbell(up_to="100 Hz")
    result.critical_speeds[0].speed          # rad/s
"""

from __future__ import annotations

from functools import cache, wraps
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

from amb_analysis.studies.figures import figure as figure
from amb_analysis.studies.figures import save as save

if TYPE_CHECKING:
    from amb_analysis.studies.bearing_axis import linearisation as linearisation
    from amb_analysis.studies.campbell_diagram import campbell as campbell
    from amb_analysis.studies.closed_loop_poles import poles as poles
    from amb_analysis.studies.contact_convergence import convergence as convergence
    from amb_analysis.studies.contact_traps import traps as traps
    from amb_analysis.studies.coupling_order import coupling as coupling
    from amb_analysis.studies.frequency_responses import response as response
    from amb_analysis.studies.natural_modes import modes as modes
    from amb_analysis.studies.receptance_identification import identify as identify
    from amb_analysis.studies.rotor_fit import fit as fit
    from amb_analysis.studies.rotor_layout import layout as layout
    from amb_analysis.studies.run_spectra import waterfall as waterfall
    from amb_analysis.studies.sensor_receptance import receptance as receptance
    from amb_analysis.studies.stability_margin import sensitivity as sensitivity
    from amb_analysis.studies.unbalance_over_speed import unbalance_response as unbalance_response

    STUDIES: dict[str, Study]  # of all packages, by name


class Study(NamedTuple):
    """Name of the module with a study's function (full, or relative to its package), and a one-line description.

    Examples
    --------
    >>> Study(".campbell_diagram", "Draw the Campbell diagram of a rotor.").of("amb_analysis.studies").module
    'amb_analysis.studies.campbell_diagram'
    """

    module: str
    description: str

    def of(self, package: str) -> Study:
        """Return this study, with the full name of its module."""
        return self._replace(module=package + self.module) if self.module.startswith(".") else self


_GENERAL = {
    "layout": Study(".rotor_layout", "Show parts, mass and modes of a rotor, its model in the plant, and a picture."),
    "campbell": Study(".campbell_diagram", "Draw the Campbell diagram of a rotor."),
    "modes": Study(".natural_modes", "List natural frequencies and draw mode shapes."),
    "unbalance_response": Study(".unbalance_over_speed", "Compute the unbalance response over speed."),
    "coupling": Study(
        ".coupling_order",
        "Compare execution orders and step sizes. The results are the orbit, outcome and cost of a scenario.",
    ),
    "convergence": Study(
        ".contact_convergence",
        "Check the convergence of contact forces. The study varies modes, mesh, substep and start.",
    ),
    "sensitivity": Study(
        ".stability_margin",
        "Compute the stability margin of ISO 14839-3. It is also measured in a co-simulation.",
    ),
    "poles": Study(
        ".closed_loop_poles",
        "Draw the Campbell diagram of the levitated rotor.",
    ),
    "traps": Study(
        ".contact_traps",
        "Find states of sustained contact. The results include the stability of each state and the force that frees "
        "the rotor.",
    ),
    "linearisation": Study(
        ".bearing_axis",
        "Linearise an axis of a magnetic bearing. Results are K_s, K_i, load capacity, slew rate and bandwidth.",
    ),
    "receptance": Study(".sensor_receptance", "Compute synchronous responses to bearing forces."),
    "response": Study(
        ".frequency_responses",
        "Compute frequency responses. They are overlaid on measured ones if a measurement is given.",
    ),
    "fit": Study(
        ".rotor_fit",
        "Fit a rotor or a machine to a measurement. Each parameter gets a 95 % interval; parameters that the data do "
        "not determine are refused.",
    ),
    "waterfall": Study(
        ".run_spectra",
        "Draw spectra over time for a run or a saved result.",
    ),
    "identify": Study(
        ".receptance_identification",
        "Identify receptances of the levitated rotor, as its controller does.",
    ),
}


def __getattr__(name: str) -> Any:
    """Import the function of a study when it is first used."""
    if name == "STUDIES":
        return _all_studies()
    study = None if name.startswith("__") else study_of(name)
    if study is None:
        names = ", ".join(_all_studies())
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}; the studies are {names}")
    return _as_users_call_it(study.module, name)


@cache
def _as_users_call_it(module: str, name: str) -> Any:
    """Return the function of a study, limited to one thread of linear algebra, which gives its warnings to Python.

    Several threads would wait for each other.
    """
    from amb_cosim.cosim.errors import give_warnings
    from amb_cosim.cosim.processes.blas import one_blas_thread

    function = one_blas_thread()(getattr(import_module(module, __name__), name))

    @wraps(function)
    def study(*arguments: Any, **options: Any) -> Any:
        result = function(*arguments, **options)
        give_warnings(getattr(result, "warnings", ()))
        return result

    return study


def study_of(name: str) -> Study | None:
    """Return the study of that name, from this package or another; None if there is no such study."""
    return _GENERAL.get(name) or _all_studies().get(name)


def __dir__() -> list[str]:
    return sorted({"STUDIES", "Study", "figure", "save", *_all_studies()})


@cache
def _all_studies() -> dict[str, Study]:
    """Return all studies, by name."""
    from amb_files.packs import modules_of

    studies = dict(_GENERAL)
    for package, module in modules_of("studies", "STUDIES").items():
        if duplicates := sorted(studies.keys() & module.STUDIES):
            raise ValueError(f"{package} must rename its study {duplicates[0]!r}: the name is in use")
        studies |= {name: study.of(module.__name__) for name, study in module.STUDIES.items()}
    return studies
