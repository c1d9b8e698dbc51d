"""The contact laws of a site: number, name, description, formula and parameters of each.

    0           constraint: rigid, solved in `contact.constraints`
    1, 2, ...   `COMPLIANT`, in this order: the classical laws (thesis 4.1 to 4.9, 4.13), for comparison

A law consists of a function of penetration and rate, which returns a `Response`, and of a line in `COMPLIANT`, which
gives the law its number. The function reads the parameters of the law from the site; `law_parameters` declares them.
docs/theory/contact_laws.md states the equations, in which v_s is `RATE_SCALE`. Because K = k_c / sqrt(delta_c), k_c is
the secant stiffness at delta_c of the laws with a power of 3/2.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fmi_export.jit import views
from fmi_export.variables import Enumeration, Variable

RATE_SCALE = 0.01  # m/s, over which the phase of ulbrich changes its sign


class Response(NamedTuple):
    """Response of a contact to its penetration delta >= 0 (m) and its rate (m/s).

    `push` passes through zero where cutting off the pull gives N a kink: at k_c delta + c_c delta' = 0 for spring and
    damper, and where the factor of the rate vanishes for the laws with a power of 3/2.
    """

    force: float  # N (N); a negative value would pull, and is cut off
    push: float  # a force (N) that is positive where the law pushes the journal, and negative where it would pull
    stored: float  # elastic energy (J): the integral of the force at rate zero
    elastic: float  # its derivative with respect to delta (N); the difference between N and this one is dissipated
    stiffness: float  # a bound on the derivative of N with respect to delta (N/m), which limits substeps
    damping: float  # the same with respect to the rate (N s/m)


Law = Callable[[np.record, float, float], Response]


@views
def linear(site: np.record, delta: float, rate: float) -> Response:
    """Return the response of a spring (4.1, 4.2)."""
    elastic = site.k_c * delta
    return Response(
        force=elastic,
        push=1.0,
        stored=0.5 * site.k_c * delta * delta,
        elastic=elastic,
        stiffness=1.5 * site.k_c,
        damping=0.0,
    )


@views
def hertz(site: np.record, delta: float, rate: float) -> Response:
    """Return the response of a force that grows with the power 3/2 of the penetration (4.1)."""
    root = math.sqrt(delta / site.delta_c)
    elastic = site.k_c * delta * root
    return Response(
        force=elastic,
        push=1.0,
        stored=0.4 * site.k_c * delta * delta * root,
        elastic=elastic,
        stiffness=1.5 * site.k_c * root,
        damping=0.0,
    )


@views
def kelvin_voigt(site: np.record, delta: float, rate: float) -> Response:
    """Return the response of a spring and a damper (4.3)."""
    elastic = site.k_c * delta
    viscous = elastic + site.c_c * rate
    return Response(
        force=viscous,
        push=viscous,
        stored=0.5 * site.k_c * delta * delta,
        elastic=elastic,
        stiffness=1.5 * site.k_c,
        damping=site.c_c,
    )


@views
def kirk(site: np.record, delta: float, rate: float) -> Response:
    """Return the response of a spring and a damper that engage gradually with penetration (4.4, 4.5)."""
    elastic = site.k_c * delta
    viscous = elastic + site.c_c * rate
    d = site.delta_c / 3.0
    rest = math.exp(-3.0 * (delta / site.delta_c))
    return Response(
        force=viscous * (1.0 - rest),
        push=viscous,
        stored=site.k_c * (0.5 * delta * delta - d * d + d * (delta + d) * rest),
        elastic=elastic * (1.0 - rest),
        stiffness=1.5 * site.k_c + 3.0 * site.c_c * abs(rate) / site.delta_c,
        damping=site.c_c,
    )


@views
def hunt_crossley(site: np.record, delta: float, rate: float) -> Response:
    """Return Hertz's response with damping (4.6, 4.7)."""
    root = math.sqrt(delta / site.delta_c)
    elastic = site.k_c * delta * root
    factor = 1.0 + 1.5 * site.alpha_c * rate
    return Response(
        force=elastic * factor,
        push=factor * (site.k_c * site.delta_c),
        stored=0.4 * site.k_c * delta * delta * root,
        elastic=elastic,
        stiffness=1.5 * site.k_c * root * (1.0 + 1.5 * site.alpha_c * abs(rate)),
        damping=1.5 * site.alpha_c * site.k_c * delta * root,
    )


@views
def ulbrich(site: np.record, delta: float, rate: float) -> Response:
    """Return Hertz's response with loss (4.8, 4.9)."""
    root = math.sqrt(delta / site.delta_c)
    elastic = site.k_c * delta * root
    factor = 1.0 + 1.5 * site.eta * math.tanh(rate / RATE_SCALE)
    return Response(
        force=elastic * factor,
        push=factor * (site.k_c * site.delta_c),
        stored=0.4 * site.k_c * delta * delta * root,
        elastic=elastic,
        stiffness=1.5 * site.k_c * root,
        damping=1.5 * (site.eta / RATE_SCALE) * site.k_c * delta * root,
    )


@views
def switched_kelvin_voigt(site: np.record, delta: float, rate: float) -> Response:
    """Return the response of a spring and a damper that never pull (4.13).

    Because the integral of the force has no simple form, the energy of the spring is used, and the difference counts as
    reversible heat.
    """
    elastic = site.k_c * delta
    viscous = elastic + site.c_c * rate
    switch = 0.5 * (1.0 + math.tanh(viscous / (site.k_c * site.delta_c)))
    return Response(
        force=viscous * math.tanh(delta / site.delta_c) * switch,
        push=viscous,
        stored=0.5 * site.k_c * delta * delta,
        elastic=elastic,
        stiffness=1.5 * site.k_c + 3.0 * site.c_c * abs(rate) / site.delta_c,
        damping=site.c_c,
    )


COMPLIANT: tuple[tuple[Law, str], ...] = (  # formulas, whose names the laws have, with their descriptions
    (linear, "a spring"),
    (hertz, "a force that grows with the power 3/2 of the penetration"),
    (kelvin_voigt, "a spring and a damper"),
    (kirk, "a spring and a damper that engage gradually with the penetration"),
    (hunt_crossley, "the hertz law with damping"),
    (ulbrich, "the hertz law with a loss"),
    (switched_kelvin_voigt, "a spring and a damper with a smooth switch at zero penetration and at zero force"),
)
CONTACT_LAW = Enumeration(
    "ContactLaw",
    (("constraint", "a rigid contact"), *((formula.__name__, description) for formula, description in COMPLIANT)),
)
LAWS = CONTACT_LAW.names
CONSTRAINT = 0


def _formula_from(number: int) -> Law:
    """Return a function that evaluates a site's law, for laws whose numbers are at least `number`."""
    formula = COMPLIANT[number - 1][0]
    if number == len(COMPLIANT):
        return formula
    later = _formula_from(number + 1)

    @views
    def chosen(site: np.record, delta: float, rate: float) -> Response:
        if site.law == number:
            return formula(site, delta, rate)
        return later(site, delta, rate)

    return chosen


compliant_response = _formula_from(1)


def law_parameters(declare: Callable[..., Variable]) -> list[Variable]:
    """Return the parameters of the compliant laws at a site, whose variables `declare` declares (`at_place`)."""

    def users(name: str) -> str:
        *others, last = (formula.__name__ for formula, _ in COMPLIANT if name in formula.__code__.co_names)
        return " and ".join([", ".join(others), last] if others else [last])

    return [
        declare(
            "k_c",
            "N/m",
            "Contact stiffness {} of all laws except constraint, or the force per penetration at delta_c if the "
            "stiffness grows with the penetration",
            1e8,
            minimum=1.0,
            maximum=1e12,
        ),
        declare("c_c", "N.s/m", f"Contact damping {{}}, used by {users('c_c')}", 0.0, minimum=0.0, maximum=1e9),
        declare(
            "delta_c", "m", f"Reference penetration {{}}, used by {users('delta_c')}", 1e-5, minimum=1e-9, maximum=1e-2
        ),
        declare("alpha_c", "s/m", f"Damping factor {{}}, used by {users('alpha_c')}", 0.0, minimum=0.0, maximum=1e3),
        declare("eta", "1", f"Loss factor {{}}, used by {users('eta')}", 0.0, minimum=0.0, maximum=0.66),
    ]
