"""How the co-simulation of the three FMUs converges to the levitated rotor as a whole, over the communication step.

The rotor starts from rest under an unbalance. The controller samples at a fixed rate, so that the sampled system is
the same at every communication step and all that differs is the coupling. In Jacobi order the controller's currents
appear when its step has passed, a sample late; the system as a whole is then taken with that delay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from rich.table import Table

from amb_actuator.interface import DYNAMIC, IDEAL, MEASURED, NONLINEAR
from amb_analysis.design import axis_parameters, constants
from amb_cosim.cosim.master import Coupling
from amb_cosim.scenario import Scenario, make_scenario
from amb_cosim.simulation import prepare, run
from amb_cosim.studies import loop_figures
from amb_cosim.studies.monolithic import Case, Complex, free_orbit
from amb_cosim.studies.outcome import Outcome
from amb_cosim.text_tables import labelled_table

DURATION = 0.1  # s from rest, two turns
SUBSTEP = 15.625e-6  # s, of the plant's own integration; the shortest communication step
EXACT = 1e-6  # of the orbit; a coupling that errs less leaves only the plant's own integration


@dataclass(frozen=True)
class Scheme:
    """How the FMUs are coupled: order of the master, force with its gradient, force of a step's mean current."""

    coupling: Coupling = "gauss_seidel"
    gradient: bool = True
    mean_current: bool = False


@dataclass(frozen=True)
class Comparison:
    """One case with the schemes to compare, by what they are called, and the communication steps (s)."""

    title: str
    case: Case
    schemes: dict[str, Scheme]
    steps: tuple[float, ...]


HALVED = tuple(SUBSTEP * 2**k for k in range(5, -1, -1))  # 500 us to 15.6 us


def comparisons() -> list[Comparison]:
    """The cases of the study."""
    linear = Case(Omega=120.0, disc="d3", unbalance=0.02)
    k_s, k_i = constants(axis_parameters())
    orders = {
        "Gauss-Seidel, force held": Scheme(gradient=False),
        "Gauss-Seidel, with gradient": Scheme(),
        "Jacobi, force held": Scheme("jacobi", gradient=False),
        "Jacobi, with gradient": Scheme("jacobi"),
    }
    currents = {
        "current at the end, force held": Scheme(gradient=False),
        "current at the end, with gradient": Scheme(),
        "mean current, force held": Scheme(gradient=False, mean_current=True),
        "mean current, with gradient": Scheme(mean_current=True),
    }
    gradients = {"Gauss-Seidel, force held": Scheme(gradient=False), "Gauss-Seidel, with gradient": Scheme()}
    return [
        Comparison("linear law, controller at 2 kHz", replace(linear, sample_time=500e-6), orders, HALVED),
        Comparison("linear law, controller at 4 kHz", linear, orders, HALVED[1:]),
        Comparison("amplifiers of 1.4 kHz, Gauss-Seidel", replace(linear, bandwidth=1400.0), currents, HALVED[1:]),
        Comparison(
            "nonlinear law with saturation", replace(linear, k_s=k_s, k_i=k_i, nonlinear=True), gradients, HALVED[1:]
        ),
    ]


def coupling() -> Outcome:
    """Errors of the co-simulation over the communication step, and their orders."""
    data: dict[str, Any] = {
        "duration_s": DURATION,
        "substep_s": SUBSTEP,
        "comparisons": [compare(comparison) for comparison in comparisons()],
    }
    return Outcome(data, {"coupling": partial(loop_figures.coupling, data)}, as_text(data))


def compare(comparison: Comparison, duration: float = DURATION) -> dict[str, Any]:
    """Errors of each scheme at each step, and observed orders, ready for JSON.

    An error is the largest distance of the orbits at both bearings from the whole system's at the controller's samples,
    over the largest displacement.
    """
    case, schemes = comparison.case, {}
    samples = math.ceil(duration / case.sample_time)
    exact = {
        order: free_orbit(replace(case, delay=delay), samples)
        for order, delay in (("gauss_seidel", 0), ("jacobi", 1))
        if any(scheme.coupling == order for scheme in comparison.schemes.values())
    }
    for name, scheme in comparison.schemes.items():
        reference = exact[scheme.coupling]
        errors = [
            float(np.abs(cosimulated(case, scheme, step, samples) - reference).max() / np.abs(reference).max())
            for step in comparison.steps
        ]
        schemes[name] = {"errors": errors, "order": observed_order(comparison.steps, errors)}
    return {
        "title": comparison.title,
        "sample_time_s": case.sample_time,
        "steps_s": list(comparison.steps),
        "schemes": schemes,
    }


def observed_order(steps: Sequence[float], errors: Sequence[float]) -> float | None:
    """Order between the two shortest steps, log(e_1/e_2)/log(h_1/h_2); None if the coupling leaves no error."""
    if max(errors) < EXACT:
        return None
    (h_1, e_1), (h_2, e_2) = list(zip(steps, errors, strict=True))[-2:]
    return math.log(e_1 / e_2) / math.log(h_1 / h_2)


def cosimulated(case: Case, scheme: Scheme, step: float, samples: int, substep: float = SUBSTEP) -> Complex:
    """Complex displacement at MB1 and MB2 (m) at each sample from a co-simulation of the three FMUs.

    Parameters
    ----------
    case
        What is simulated.
    scheme, step
        How the FMUs are coupled, and the communication step (s), a whole part of the case's sample time.
    samples
        How many samples the controller takes.
    substep
        Longest step of the plant's own integration (s).

    Raises
    ------
    ValueError
        If the co-simulation does not come to its end.
    """
    outcome = run(prepare("coupling", scenario(case, scheme, step, samples, substep)))
    if outcome.failure is not None:
        raise ValueError(outcome.failure)
    bearings = [
        outcome.dataset[f"rotor_contact.{at}.x"].values + 1j * outcome.dataset[f"rotor_contact.{at}.y"].values
        for at in ("mb1", "mb2")
    ]
    return np.array(bearings).T


def scenario(case: Case, scheme: Scheme, step: float, samples: int, substep: float) -> Scenario:
    """The scenario of a case: an unbalanced rotor from rest."""
    actuator: dict[str, float] = {
        "force_law": NONLINEAR if case.nonlinear else MEASURED,
        "amplifier": IDEAL if case.bandwidth is None else DYNAMIC,
        "mean_current": scheme.mean_current,
        "*.k_s_measured_?": case.k_s,
        "*.k_i_measured_?": case.k_i,
    }
    if case.bandwidth is not None:
        actuator["*.bandwidth_?"] = case.bandwidth
    return make_scenario(
        {
            "description": "An unbalanced rotor from rest",
            "Omega": case.Omega,
            "settle_cycles": 0,
            "end_time": samples * case.sample_time,
            "gradient": scheme.gradient,
            "coupling": scheme.coupling,
            "communication_step": step,
            "inputs": {"rotor_contact": {f"{case.disc}.u": case.unbalance}},
            "parameters": {
                "rotor_contact": {"solver.max_substep": substep},
                "amb_actuator": actuator,
                "rolac_controller": {
                    "sample_time": case.sample_time,
                    "*.k_s_?": case.k_s,
                    "*.k_i_?": case.k_i,
                    "*.k_b_?": case.k_b,
                    "*.c_b_?": case.c_b,
                },
            },
            "record": {"variables": ["rotor_contact.mb?.?"], "every": round(case.sample_time / step)},
        },
        "coupling",
    )


def as_text(data: dict[str, Any]) -> list[Table | str]:
    """What `coupling` found, to print."""
    parts: list[Table | str] = []
    for comparison in data["comparisons"]:
        steps = (f"{1e6 * step:g}" for step in comparison["steps_s"])
        label = "error of the orbit at a communication step (us) of"
        table = labelled_table(comparison["title"], label, *steps, "order")
        for name, scheme in comparison["schemes"].items():
            order = "exact" if scheme["order"] is None else f"{scheme['order']:.2f}"
            table.add_row(name, *(f"{error:.1e}" for error in scheme["errors"]), order)
        parts.append(table)
    return parts
