"""Quantities and plots for statements, from this package and from the module named in a file.

Quantities and plots are the public functions of a module. Their first argument is a run (`Signals`), or the result of a
study. A function that returns panels is a plot. Any other function is a quantity. The annotation of its return type
contains the unit, as in `Annotated[float, "N"]`. Texts, truth values, and numbers with their own units do not need this
annotation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from importlib import import_module
from inspect import isfunction
from typing import Any, NamedTuple, get_args, get_type_hints

from amb_assessment.reporting.panels import Panel, run_panels
from amb_cosim.cosim.record.signals import Signals
from source_check import run_quantities, study_panels, study_quantities

Quantities = Mapping[str, tuple[Callable[..., Any], str]]
"""Functions by name, each with the unit of the numbers that it returns."""


def quantities_of_runs(module: str = "") -> Quantities:
    """Return the quantities of runs, including those of `module` if it is not empty."""
    functions = _functions(run_quantities.__name__, module)
    return {f.call.__name__: (f.call, f.unit) for f in functions if f.subject is Signals and not f.draws}


def quantities_of_studies(module: str = "") -> Quantities:
    """Return the quantities of studies, including those of `module` if it is not empty."""
    functions = _functions(study_quantities.__name__, module)
    return {f.call.__name__: (f.call, f.unit) for f in functions if is_dataclass(f.subject) and not f.draws}


def panels_of_run(run: Signals, module: str = "") -> tuple[Panel, ...]:
    """Return the plots of a run, including those of `module` if it is not empty."""
    return run_panels(run, [f.call for f in _functions(module) if f.subject is Signals and f.draws])


def panels_of_study(result: Any, module: str = "") -> tuple[Panel, ...]:
    """Return the plots of a study's result from this package or `module`; empty if neither has a plot for it."""
    plots = [f for f in _functions(study_panels.__name__, module) if f.draws and is_dataclass(f.subject)]
    return next((tuple(f.call(result)) for f in plots if isinstance(result, f.subject)), ())


class _Function(NamedTuple):
    """A public function of a module, with the type of its first argument, its unit, and whether it returns panels."""

    call: Callable[..., Any]
    subject: Any
    unit: str
    draws: bool


def _functions(*modules: str) -> Iterator[_Function]:
    """Yield the public functions of modules, if they take arguments; empty module names are ignored."""
    for module in filter(None, modules):
        for function in vars(import_module(module)).values():
            if isfunction(function) and function.__module__ == module and not function.__name__.startswith("_"):
                *arguments, returned = get_type_hints(function, include_extras=True).values()
                if arguments:
                    unit = str(getattr(returned, "__metadata__", ("",))[0])
                    yield _Function(function, arguments[0], unit, get_args(returned) == (Panel,))
