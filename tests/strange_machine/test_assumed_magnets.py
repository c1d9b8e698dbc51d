"""What the controller of the expander assumes of its magnets follows from them, with gravity and without."""

import pytest
from strange_machine import LEVITATION

import amb_cosim
from amb_cosim.model_constants.magnetic_bearing import axis_parameters, current_range, linear_constants
from amb_cosim.scenario.prepare_run import prepare_run
from amb_cosim.scenario.scenario import load_scenario
from tests.support.messages import assert_names

WEIGHTLESS = load_scenario(LEVITATION).changed(gravity=None, settle_cycles=0)
LINEAR = {"amb_actuator.force_law": "linear"}
OF_MAGNET = ("turns", "pole_area", "gap", "bias_current", "static_current")


@pytest.mark.parametrize("gravity", [None, "9.81 m/s2"], ids=["weightless", "heavy"])
@pytest.mark.parametrize("gap", ["0.4 mm", "0.6 mm"])
def test_controller_assumes_the_constants_of_its_magnets(gravity: str | None, gap: str) -> None:
    """K_s and K_i by (2.8, 2.9), currents from -(I_s + I_b) to I_b."""
    settings = LINEAR | {"amb_actuator.*.gap_?": gap, "amb_actuator.*.bias_current_y": "2.5 A"}
    scenario = WEIGHTLESS.changed(gravity=gravity)
    parameters = prepare_run(scenario, settings).parameters
    assumed, magnets = parameters["rolac_controller"], parameters["amb_actuator"]
    for bearing in ("north", "south"):
        for axis in "xy":
            magnet = axis_parameters(bearing, axis, **{n: magnets[f"{bearing}.{n}_{axis}"] for n in OF_MAGNET})
            k_s, k_i = linear_constants(magnet)
            assert assumed[f"{bearing}.k_s_{axis}"] == pytest.approx(k_s, rel=1e-12)
            assert assumed[f"{bearing}.k_i_{axis}"] == pytest.approx(k_i, rel=1e-12)
            least = -(magnet.static_current + magnet.bias_current)
            assert assumed[f"{bearing}.i_min_{axis}"] == pytest.approx(least, rel=1e-12)


@pytest.mark.parametrize("limit", [4.5, 8.0])
def test_controller_demands_no_current_that_the_coils_cannot_carry(limit: float) -> None:
    """Both coils of an axis carry 0 A to the limit, of which 4.5 A are less than 2 I_b + I_s."""
    settings = LINEAR | {"amb_actuator.*.current_limit_?": limit, "amb_actuator.*.static_current_y": 0.5}
    pid = {n: raw for n, raw in WEIGHTLESS.parameters["rolac_controller"].items() if "i_max" not in n}
    unstated = WEIGHTLESS.model_copy(update={"parameters": {**WEIGHTLESS.parameters, "rolac_controller": pid}})
    parameters = prepare_run(unstated, settings).parameters
    assumed, magnets = parameters["rolac_controller"], parameters["amb_actuator"]
    for axis in "xy":
        own = {n: magnets[f"north.{n}_{axis}"] for n in (*OF_MAGNET, "current_limit")}
        low, high = (assumed[f"north.{name}_{axis}"] for name in ("i_min", "i_max"))
        assert (low, high) == pytest.approx(current_range(axis_parameters(**own)), rel=1e-12)


def test_weightless_expander_levitates_on_its_own_magnets() -> None:
    """With K_s and K_i of another machine its 0.3 N/um are lost on magnets that pull harder."""
    run = amb_cosim.run(WEIGHTLESS, set={"amb_actuator.*.static_current_?": 0}, until="5 ms", progress=False)
    assert float(abs(run.dataset["rotor_contact.north.x"]).max()) < 2e-6
    assert not [w for w in run.summary.warnings if "magnets" in w]


def test_static_currents_of_another_machine_warn_without_gravity() -> None:
    """They raise K_s; a vertical shaft has gravity 0, and its coils the bias current alone."""
    magnets = {n: raw for n, raw in WEIGHTLESS.parameters["amb_actuator"].items() if "static_current" not in n}
    unstated = WEIGHTLESS.model_copy(update={"parameters": {**WEIGHTLESS.parameters, "amb_actuator": magnets}})
    kept = prepare_run(unstated, LINEAR)
    assert_names(kept.warnings[-1], "static_current", "1.14 A", "north.x", "south.y", "gravity")
    vertical = prepare_run(unstated.changed(gravity="0 m/s2"), LINEAR)
    stated = prepare_run(unstated, LINEAR | {"amb_actuator.*.static_current_?": 0})
    for plan in (vertical, stated):
        assert not plan.warnings
        bias = plan.parameters["amb_actuator"]["north.bias_current_x"]
        ratio = ((bias + 1.14) ** 2 + bias**2) / (2.0 * bias**2)
        k_s, of_kept = (p.parameters["rolac_controller"]["north.k_s_x"] for p in (plan, kept))
        assert of_kept == pytest.approx(ratio * k_s, rel=1e-9)


@pytest.mark.parametrize(("factor", "warns"), [(1.4, False), (0.7, False), (1.6, True), (0.6, True)])
def test_constants_far_from_those_of_the_magnets_warn(factor: float, warns: bool) -> None:
    own = prepare_run(WEIGHTLESS, LINEAR).parameters["rolac_controller"]["north.k_s_x"]
    given = LINEAR | {"rolac_controller.north.k_s_x": factor * own}
    warnings = amb_cosim.run(WEIGHTLESS, set=given, until="1 ms", progress=False).summary.warnings
    both = f"rolac_controller.north.k_s_x = {factor * own:.4g} N/m, but {own:.4g} N/m according to the magnet"
    assert any(both in warning for warning in warnings) == warns


def test_measured_constants_of_another_machine_warn() -> None:
    """Geometry is given, the force law is that of constants which are not."""
    warnings = prepare_run(WEIGHTLESS, {"amb_actuator.force_law": "measured"}).warnings
    assert_names(warnings[0], "amb_actuator.north.k_s_measured_x", "2e+06 N/m", "3.526e+05 N/m")
    measured = {"amb_actuator.force_law": "measured", "amb_actuator.*.k_[si]_measured_?": 2e3}
    assert not prepare_run(WEIGHTLESS, measured).warnings
