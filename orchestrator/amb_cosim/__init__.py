"""Co-simulation of a flexible rotor in active magnetic bearings that can touch its retainer bearings.

    import amb_cosim
    result = amb_cosim.run("drop", set={"rotor_contact.*.clearance": "0.6 mm"}, until=0.3)

    run          run a scenario and return its Result
    scenarios    names and descriptions of the scenarios of the packs
    Scenario     a scenario as an object: load, changed, save
    check        check a scenario against the components that it runs
    compare      compare runs or saved results: table of summaries, overlaid figures
    Result       a run: dataset, summary, plot, outcome, save; Result.load reads one from its folder
    linearise    return the linear model of a machine, a part, or its sampled loop, as control.StateSpace
    linear_controller  make a controller from a law: python-control, SciPy, arrays, a dict of speeds, a file
    build        write the FMUs of rotor, actuator and controller, for use in any tool
    build_assembled  write an FMU that holds all three, for masters that could not couple them well
    verify       run the experiments in an FMU, and compare with its reference results
    export_ssp   write a scenario with its FMUs as an SSP archive, for other tools
    identify     identify receptances of the levitated rotor by co-simulation, into a table for ROLAC
    sweep        run a scenario over a grid or a sample of values, thousands of runs, on Dask
    draw_sweep   draw maps of a sweep into its folder
    assess       assess a machine by criteria of standards, with figures
    units        choose the units of figures, from now on or in a `with`: units("rpm", "um", "kN")
    live         the page that runs a scenario in a browser, displayed in a notebook: live("my_scenario.toml")
    studies      analyses of a machine: Campbell diagram, sensitivity, robustness, ...
    simulate     run any co-simulation FMUs (FMI 2.0 and 3.0) from a system file or an SSP archive
    System       your own components and connections
    load_system  read a system file, or a system by its name
    cosim        the layer below, which knows FMI but no rotor: components, master, recording

    ModelWarning, FmuError, StartFailed, ProcessFailed, Interrupted  for `warnings.filterwarnings` and `except`

For documentation, use for example help(amb_cosim.run); `__version__` is the version. Invalid input raises ValueError,
and the message names the value and the allowed range. Each part is loaded at first use.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # as in `typing`, which takes longer to import than all of this

if TYPE_CHECKING:
    from typing import Any

    from amb_analysis import studies as studies
    from amb_analysis.linear.linearise import linearise as linearise
    from amb_analysis.studies.receptance_identification import identify as identify
    from amb_assessment.assessment.engine.assess import assess as assess
    from amb_cosim import cosim as cosim
    from amb_cosim.comparison.compare import compare as compare
    from amb_cosim.controllers.linear_controller import linear_controller as linear_controller
    from amb_cosim.cosim.errors import FmuError as FmuError
    from amb_cosim.cosim.errors import Interrupted as Interrupted
    from amb_cosim.cosim.errors import ModelWarning as ModelWarning
    from amb_cosim.cosim.errors import ProcessFailed as ProcessFailed
    from amb_cosim.cosim.errors import StartFailed as StartFailed
    from amb_cosim.cosim.run.simulate import simulate as simulate
    from amb_cosim.cosim.system.system import System as System
    from amb_cosim.cosim.system.system_file import load_system as load_system
    from amb_cosim.cosim.verify.verification import verify as verify
    from amb_cosim.export.assembled import build_assembled as build_assembled
    from amb_cosim.export.build import build as build
    from amb_cosim.export.exchange import export_ssp as export_ssp
    from amb_cosim.presentation.units import units as units
    from amb_cosim.results.result import Result as Result
    from amb_cosim.scenario.scenario import Scenario as Scenario
    from amb_cosim.scenario.scenario import scenarios as scenarios
    from amb_cosim.scenario.simulation import check as check
    from amb_cosim.scenario.simulation import run as run
    from amb_live.notebook import LivePage
    from amb_sweeps.figures import draw_sweep as draw_sweep
    from amb_sweeps.run import sweep as sweep

    __version__: str

    def live(*arguments: Any, **options: Any) -> LivePage: ...


_MODULES = {
    "run": "amb_cosim.scenario.simulation",
    "scenarios": "amb_cosim.scenario.scenario",
    "Scenario": "amb_cosim.scenario.scenario",
    "check": "amb_cosim.scenario.simulation",
    "Result": "amb_cosim.results.result",
    "compare": "amb_cosim.comparison.compare",
    "linearise": "amb_analysis.linear.linearise",
    "linear_controller": "amb_cosim.controllers.linear_controller",
    "build": "amb_cosim.export.build",
    "build_assembled": "amb_cosim.export.assembled",
    "verify": "amb_cosim.cosim.verify.verification",
    "export_ssp": "amb_cosim.export.exchange",
    "identify": "amb_analysis.studies.receptance_identification",
    "sweep": "amb_sweeps.run",
    "draw_sweep": "amb_sweeps.figures",
    "assess": "amb_assessment.assessment.engine.assess",
    "units": "amb_cosim.presentation.units",
    "live": "amb_live",
    "studies": "amb_analysis.studies",
    "simulate": "amb_cosim.cosim.run.simulate",
    "System": "amb_cosim.cosim.system.system",
    "load_system": "amb_cosim.cosim.system.system_file",
    "cosim": "amb_cosim.cosim",
    **dict.fromkeys(
        ("ModelWarning", "FmuError", "StartFailed", "ProcessFailed", "Interrupted"), "amb_cosim.cosim.errors"
    ),
}

_PACKAGES = ("live", "studies", "cosim")  # names that are packages

__all__ = [*_MODULES]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("amb-cosim")
    if name not in _MODULES:
        raise AttributeError(f"module 'amb_cosim' has no attribute {name!r}; there are {', '.join(_MODULES)}")
    module = import_module(_MODULES[name])
    return module if name in _PACKAGES else getattr(module, name)


def __dir__() -> list[str]:
    return [*_MODULES]
