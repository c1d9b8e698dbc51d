"""Observed orders of the coupling: the three FMUs against the levitated rotor as a whole."""

from collections.abc import Callable
from typing import Any

import pytest

pytestmark = pytest.mark.slow

LINEAR, AMPLIFIERS, NONLINEAR = ("linear law, controller at 4 kHz", "amplifiers of 1.4 kHz", "nonlinear law")


def studied() -> list[dict[str, Any]]:
    """The study's comparisons at three communication steps, over a shorter time."""
    from dataclasses import replace

    from amb_cosim.presentation.json_data import json_data
    from bath_thesis.studies.coupling_convergence import compare, comparisons

    return [json_data(compare(replace(c, steps=(125e-6, 62.5e-6, 31.25e-6)), duration=0.05)) for c in comparisons()]


@pytest.fixture(scope="module")
def schemes(run_once: Callable[..., Any]) -> Callable[[str, str], dict[str, Any]]:
    """Return errors and order of a scheme in the comparison whose title begins with `title`."""
    result = run_once(studied, timeout=300)

    def of(title: str, name: str) -> dict[str, Any]:
        (comparison,) = (c for c in result if c["title"].startswith(title))
        return comparison["schemes"][name]

    return of


@pytest.mark.parametrize("title", ["linear law, controller at 2 kHz", LINEAR])
@pytest.mark.parametrize("name", ["Gauss-Seidel, force held", "Jacobi, force held", "Jacobi, with gradient"])
def test_forces_held_over_a_step_converge_with_first_order(schemes: Any, title: str, name: str) -> None:
    assert schemes(title, name)["order"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("title", ["linear law, controller at 2 kHz", LINEAR])
def test_a_controller_that_predicts_makes_jacobi_order_second_order(schemes: Any, title: str) -> None:
    late, predicting = (schemes(title, f"Jacobi, {name}") for name in ("with gradient", "predicting"))
    assert predicting["order"] == pytest.approx(2.0, abs=0.1)
    assert predicting["errors"][0] < 0.05 * late["errors"][0]


@pytest.mark.parametrize(
    ("title", "name"), [(LINEAR, "force held"), (AMPLIFIERS, "mean current, force held"), (NONLINEAR, "force held")]
)
def test_repeated_steps_are_second_order_without_a_gradient(schemes: Any, title: str, name: str) -> None:
    explicit = {LINEAR: "Gauss-Seidel, ", AMPLIFIERS: "", NONLINEAR: "Gauss-Seidel, "}[title] + name
    iterative = schemes(title, f"iterative, {name}")
    assert iterative["order"] == pytest.approx(2.0, abs=0.05)
    assert iterative["errors"][0] < 0.01 * schemes(title, explicit)["errors"][0]


@pytest.mark.parametrize("title", ["linear law, controller at 2 kHz", LINEAR])
def test_gradient_leaves_no_coupling_error_of_a_linear_law(schemes: Any, title: str) -> None:
    scheme = schemes(title, "Gauss-Seidel, with gradient")
    assert scheme["order"] is None
    assert max(scheme["errors"]) < 1e-8


def test_gradient_makes_the_nonlinear_law_second_order(schemes: Any) -> None:
    held, followed = (schemes(NONLINEAR, f"Gauss-Seidel, {name}") for name in ("force held", "with gradient"))
    assert held["order"] == pytest.approx(1.0, abs=0.05)
    assert followed["order"] == pytest.approx(2.0, abs=0.05)
    assert followed["errors"][0] < 2e-3 * held["errors"][0]


def test_dynamic_amplifier_needs_mean_current_and_gradient_for_order_two(schemes: Any) -> None:
    orders = {
        (current, force): schemes(AMPLIFIERS, f"{current}, {force}")["order"]
        for current in ("current at the end", "mean current")
        for force in ("force held", "with gradient")
    }
    assert orders.pop(("mean current", "with gradient")) == pytest.approx(2.0, abs=0.05)
    assert list(orders.values()) == pytest.approx([1.0, 1.0, 1.0], abs=0.15)
