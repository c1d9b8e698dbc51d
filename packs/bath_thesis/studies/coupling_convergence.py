"""Study of how the co-simulation converges to the monolithic levitated rig as the communication step shrinks.

The rotor starts from rest under an unbalance. The controller samples at fixed instants, so only the coupling depends on
the communication step.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np

from amb_analysis.studies.result import DrawnResult
from amb_cosim.cosim.choices import Flavour
from amb_cosim.cosim.grid.time_grid import in_steps
from amb_cosim.cosim.run.options import DEFAULTS, RunOptions
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, linear_constants
from amb_cosim.presentation.text_tables import TextBlock, labelled_table
from array_types import Array
from bath_thesis.studies.coupled_orbit import SUBSTEP, Scheme, cosimulated
from bath_thesis.studies.monolithic import Levitation, free_orbit

DURATION = 0.1  # s from rest, two turns
EXACT = 1e-6  # relative error of the orbit, below which the error of the plant's integration is larger


@dataclass(frozen=True)
class LoopVariant:
    """One levitated rotor, the schemes that are compared (by name), and the communication steps (s)."""

    title: str
    levitation: Levitation
    schemes: dict[str, Scheme]
    steps: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class SchemeErrors:
    """Errors of a scheme.

    errors
        Largest distance from the orbits of the monolithic system, divided by the largest displacement (1), for each
        communication step, shape (n,).
    order
        Order of convergence between the two shortest steps; None if the coupling is exact.
    """

    errors: Array
    order: float | None


@dataclass(frozen=True, eq=False)
class ComparisonErrors:
    """Errors of each scheme of a comparison at each communication step.

    title
        Name of the comparison.
    sample_time
        Sample time of the controller (s).
    steps
        Communication steps (s), descending.
    schemes
        Errors, by name of the scheme.
    """

    title: str
    sample_time: Annotated[float, "s"]
    steps: Annotated[tuple[float, ...], "s"]
    schemes: dict[str, SchemeErrors]


@dataclass(frozen=True, eq=False, repr=False)
class CouplingConvergence(DrawnResult):
    """Errors of the co-simulation as a function of the communication step.

    duration
        Simulated time from rest (s).
    substep
        Longest step of the plant's own integration (s).
    comparisons
        Errors of each comparison.
    """

    name: ClassVar[str] = "coupling_error"

    duration: Annotated[float, "s"]
    substep: Annotated[float, "s"]
    comparisons: tuple[ComparisonErrors, ...]

    def text(self) -> list[TextBlock]:
        """Return a table of errors and orders for each comparison."""
        parts: list[TextBlock] = []
        for comparison in self.comparisons:
            steps = (f"{1e6 * step:g}" for step in comparison.steps)
            label = "error of the orbit at a communication step (us) of"
            table = labelled_table(comparison.title, label, *steps, "order")
            for name, scheme in comparison.schemes.items():
                order = "exact" if scheme.order is None else f"{scheme.order:.2f}"
                table.add_row(name, *(f"{error:.1e}" for error in scheme.errors), order)
            parts.append(table)
        return parts


HALVED = tuple(SUBSTEP * 2**k for k in range(5, -1, -1))  # 500 us to 15.6 us


def comparisons() -> list[LoopVariant]:
    """Return the comparisons of the study."""
    linear = Levitation(Omega=120.0, disc="d3", unbalance=0.02)
    k_s, k_i = linear_constants(axis_parameters())
    orders = {
        "Gauss-Seidel, force held": Scheme(gradient=False),
        "Gauss-Seidel, with gradient": Scheme(),
        "Jacobi, force held": Scheme("jacobi", gradient=False),
        "Jacobi, with gradient": Scheme("jacobi"),
        "Jacobi, predicting": Scheme("jacobi", predicts=True),
        "iterative, force held": Scheme("iterative", gradient=False),
    }
    currents = {
        "current at the end, force held": Scheme(gradient=False),
        "current at the end, with gradient": Scheme(),
        "mean current, force held": Scheme(gradient=False, mean_current=True),
        "mean current, with gradient": Scheme(mean_current=True),
        "iterative, mean current, force held": Scheme("iterative", gradient=False, mean_current=True),
    }
    gradients = {
        "Gauss-Seidel, force held": Scheme(gradient=False),
        "Gauss-Seidel, with gradient": Scheme(),
        "iterative, force held": Scheme("iterative", gradient=False),
        "iterative, with gradient": Scheme("iterative"),
    }
    return [
        LoopVariant("linear law, controller at 2 kHz", replace(linear, sample_time=500e-6), orders, HALVED),
        LoopVariant("linear law, controller at 4 kHz", linear, orders, HALVED[1:]),
        LoopVariant("amplifiers of 1.4 kHz", replace(linear, bandwidth=1400.0), currents, HALVED[1:]),
        LoopVariant(
            "nonlinear law with saturation", replace(linear, k_s=k_s, k_i=k_i, nonlinear=True), gradients, HALVED[1:]
        ),
    ]


def coupling_error(flavour: Flavour = "native") -> CouplingConvergence:
    """Return the errors of the co-simulation, compared with the monolithic system, and the orders of convergence.

    Parameters
    ----------
    flavour
        Flavour of the FMUs.

    Raises
    ------
    ValueError
        If a co-simulation does not reach its end.
    """
    errors = tuple(compare(comparison, options=RunOptions(flavour=flavour)) for comparison in comparisons())
    return CouplingConvergence(DURATION, SUBSTEP, errors)


def compare(comparison: LoopVariant, duration: float = DURATION, options: RunOptions = DEFAULTS) -> ComparisonErrors:
    """Return the errors of each scheme at each communication step, and the observed orders of convergence.

    An error is the largest distance between the orbits of the two systems, over all bearings and controller samples,
    divided by the largest displacement.

    Parameters
    ----------
    comparison
        The comparison.
    duration
        Simulated time from rest (s).
    options
        Options of the runs, which include the flavour of the FMUs.
    """
    levitation = comparison.levitation
    samples = math.ceil(in_steps(duration, levitation.sample_time))
    reference = free_orbit(levitation, samples)
    schemes = {}
    for name, scheme in comparison.schemes.items():
        orbits = [cosimulated(levitation, scheme, step, samples, options) for step in comparison.steps]
        errors = [float(np.abs(orbit - reference).max() / np.abs(reference).max()) for orbit in orbits]
        schemes[name] = SchemeErrors(np.array(errors), observed_order(comparison.steps, errors))
    return ComparisonErrors(comparison.title, levitation.sample_time, comparison.steps, schemes)


def observed_order(steps: Sequence[float], errors: Sequence[float]) -> float | None:
    """Return the order of convergence over the two shortest steps, log(e_1/e_2)/log(h_1/h_2); None if exact."""
    if max(errors) < EXACT:
        return None
    (h_1, e_1), (h_2, e_2) = list(zip(steps, errors, strict=True))[-2:]
    return math.log(e_1 / e_2) / math.log(h_1 / h_2)
