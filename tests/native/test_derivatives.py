"""Directional and adjoint derivatives of outputs by inputs over a step, against the equations of the models."""

import math
from ctypes import c_double, c_size_t, c_uint
from xml.etree import ElementTree

import numpy as np
import pytest
from raw import DISCARD, OK, WARNING, Library, Library3
from rig import ACTUATOR, ACTUATOR_CONSTANTS
from slow import slow_but_first

from amb_cosim.cosim.fmu.fmus import model_source
from tests.support.messages import assert_names

H = 250e-6
SHARE = 1.0 - math.exp(-H / 1e-3)  # of the input's change that the lag follows in a step


@pytest.fixture(scope="module")
def actuator(unpacked):
    return Library(unpacked(ACTUATOR, ACTUATOR_CONSTANTS))


def references(fmu, names):
    return (c_uint * len(names))(*(fmu.library.variables[name][0] for name in names)), c_size_t(len(names))


def derivative(fmu, unknowns, knowns, seed, kind="Directional"):
    """Status and derivatives."""
    values = (c_double * len(seed))(*seed)
    result = (c_double * len(unknowns if kind == "Directional" else knowns))()
    numbers = [values, result]
    if fmu.library.version == 3:
        numbers = [values, c_size_t(len(values)), result, c_size_t(len(result))]
    status = fmu.call(f"Get{kind}Derivative", *references(fmu, unknowns), *references(fmu, knowns), *numbers)
    return status, list(result)


def test_derivative_of_a_lag_is_that_of_its_equation(library):
    with library.instantiate().begin(u=2.0, gain=3.0) as fmu:
        fmu.step(0)
        before = fmu.get("y", "level")
        status, result = derivative(fmu, ["y", "level"], ["u"], [0.5])
        assert status == OK
        np.testing.assert_allclose(result, [0.5 * 3.0 * SHARE, 1.0], rtol=1e-11)
        assert fmu.get("y", "level") == before
        assert fmu.step(1) == OK


def test_a_derivative_request_changes_no_later_bit(library):
    results = []
    for requests_derivative in (False, True):
        with library.instantiate().begin(u=2.0) as fmu:
            for n in range(4):
                fmu.step(n)
                if requests_derivative:
                    assert derivative(fmu, ["y"], ["u"], [1.0])[0] == OK
            results.append(fmu.get("y", "level") + fmu.get("steps"))
    assert results[0] == results[1]


def test_adjoint_is_the_transpose_of_the_direction(unpacked, lag):
    with Library3(unpacked(lag, None, None, 3)).instantiate() as fmu:
        fmu.begin(u=2.0)
        fmu.step(0)
        status, result = derivative(fmu, ["y", "level"], ["u"], [10.0, 1.0], "Adjoint")
        assert status == OK
        np.testing.assert_allclose(result, [10.0 * SHARE + 2.0], rtol=1e-11)


@pytest.mark.parametrize(
    ("unknowns", "knowns"), [(["steps"], ["u"]), (["y"], ["hold"]), (["u"], ["y"]), (["y"], ["gain"])]
)
def test_a_request_of_an_undefined_derivative_is_harmless(library, unknowns, knowns):
    with library.instantiate().begin() as fmu:
        assert derivative(fmu, ["y"], ["u"], [1.0])[0] == DISCARD
        assert_names(fmu.log[-1][2], "derivative", "no step")
        assert fmu.step(0) == OK
        assert derivative(fmu, unknowns, knowns, [1.0])[0] == DISCARD
        assert "Real outputs" in fmu.log[-1][2] or "Float64" in fmu.log[-1][2]
        assert derivative(fmu, ["y"], ["u"], [0.0]) == (OK, [0.0])
        assert fmu.step(1) == OK


def test_a_restored_state_has_the_derivatives_over_its_own_step(library):
    with library.instantiate() as fmu, library.instantiate() as other:
        fmu.begin(u=2.0)
        fmu.step(0)
        saved, before = fmu.save(), derivative(fmu, ["y"], ["u"], [1.0])
        fmu.advance(H, H / 7)
        fmu.restore(saved)
        assert derivative(fmu, ["y"], ["u"], [1.0]) == before
        other.restore(other.deserialise(fmu.serialise(saved))[1])
        assert derivative(other, ["y"], ["u"], [1.0]) == before


def test_differences_at_a_bound_of_an_input_are_one_sided(library):
    with library.instantiate().begin(u=-10.0, gain=3.0) as fmu:
        fmu.step(0)
        status, result = derivative(fmu, ["y", "level"], ["u"], [1.0])
        assert status == OK
        np.testing.assert_allclose(result, [3.0 * SHARE, 2.0], rtol=1e-10)


def model_and_constants(name):
    return (ACTUATOR, ACTUATOR_CONSTANTS) if name == "amb_actuator" else model_source(name)


@pytest.mark.parametrize("name", slow_but_first(["amb_actuator", "rolac_controller", "rotor_contact"]))
def test_outputs_have_derivatives_by_all_inputs_except_at_kinks(unpacked, name):
    """A clearance bends where the journal is in its centre, and the angle jumps where it turns backward from zero."""
    model, constants = model_and_constants(name)
    inputs, outputs = ([v.name for v in model.interface.of(kind) if v.type == "Real"] for kind in ("input", "output"))
    with Library(unpacked(model, constants)).instantiate() as fmu:
        fmu.begin()
        for n in range(50):
            assert fmu.step(n) == OK
            if n not in (0, 49):
                continue
            answers = {(y, u): derivative(fmu, [y], [u], [1.0]) for y in outputs for u in inputs}
            refused = {pair for pair, (status, _) in answers.items() if status != OK}
            assert not [pair for pair in refused if not pair[0].endswith((".gap", "theta"))]
            assert all(np.isfinite(result[0]) for pair, (_, result) in answers.items() if pair not in refused)


def test_outputs_have_derivatives_by_stiffnesses_of_moving_bearings(unpacked):
    """A step with another stiffness is computed by substeps: 1e-6 off for any change, which is no kink."""
    model, constants = model_source("rotor_contact")
    inputs, outputs = ([v.name for v in model.interface.of(kind) if v.type == "Real"] for kind in ("input", "output"))
    stiffnesses = [name for name in inputs if name.endswith((".k_xx", ".k_yy"))]
    with Library(unpacked(model, constants)).instantiate() as fmu:
        fmu.begin(Omega=260.0, **{"d1.u": 5e-4, "solver.max_substep": 2e-5})
        for n in range(41):
            if n == 20:
                fmu.set(**dict.fromkeys(stiffnesses, -2e6))
                fmu.set(**{name: 1e-5 for name in inputs if name.endswith("_ref")})
            assert fmu.step(n) == OK
            if n in (10, 20, 25, 40):
                refused = [y for y in outputs for k in stiffnesses if derivative(fmu, [y], [k], [1.0])[0] != OK]
                assert not refused


def test_no_derivative_exists_at_the_limit_of_a_valid_range(library):
    """At u = 6 V the output `level` reaches the 12 V that it must stay below; at 5 V the model faults."""
    with library.instantiate().begin(u=6.0) as fmu:
        fmu.step(0)
        assert derivative(fmu, ["level"], ["u"], [1.0])[0] == DISCARD
        assert_names(fmu.log[-1][2], "level", "derivative", "u")
        fmu.set(u=5.0)
        assert derivative(fmu, ["level"], ["u"], [1.0])[0] == DISCARD
        assert_names(fmu.log[-1][2].replace("%%", "%"), "u = 5 V", "100 %")
        fmu.set(u=5.85)
        assert derivative(fmu, ["level"], ["u"], [1.0])[0] == OK


def test_actuator_derivatives_are_k_s_and_k_i_below_the_current_limit(actuator):
    """f = K_s x + K_i i; where the current is limited the force has another slope to each side, and none beyond."""
    with actuator.instantiate().begin() as fmu:
        fmu.step(0)
        by_x, by_i = (derivative(fmu, ["mb1.f_x"], [name], [1.0])[1][0] for name in ("mb1.x", "mb1.i_x"))
        fmu.set(**{"mb1.x": 1e-5, "mb1.i_x": 0.1})
        fmu.step(1)
        assert fmu.get("mb1.f_x")[0] == pytest.approx(1e-5 * by_x + 0.1 * by_i, rel=1e-9)
        low, high = 0.0, 20.0
        for n in range(60):
            middle = 0.5 * (low + high)
            fmu.set(**{"mb1.x": 0.0, "mb1.i_x": middle})
            fmu.step(2 + n)
            low, high = (middle, high) if fmu.get("mb1.f_x")[0] > by_i * middle * (1.0 - 1e-9) else (low, middle)
        fmu.set(**{"mb1.i_x": high})
        assert derivative(fmu, ["mb1.f_x"], ["mb1.i_x"], [1.0])[0] == DISCARD
        assert_names(fmu.log[-1][2], "mb1.f_x", "derivative", "mb1.i_x")
        status, result = derivative(fmu, ["mb1.f_x", "mb2.f_x"], ["mb1.i_x"], [1.0])
        assert (status, result[1]) == (WARNING, 0.0)
        assert math.isnan(result[0])
        assert_names(fmu.log[-1][2], "mb1.f_x", "derivative", "mb1.i_x")
        fmu.set(**{"mb1.i_x": high + 1.0})
        assert derivative(fmu, ["mb1.f_x"], ["mb1.i_x"], [1.0]) == (OK, [0.0])


@pytest.mark.parametrize(("version", "abilities"), [(2, ["Directional"]), (3, ["Directional", "Adjoint"])])
def test_description_declares_the_derivatives(unpacked, lag, version, abilities):
    root = ElementTree.parse(unpacked(lag, None, None, version) / "modelDescription.xml").getroot()
    plural = "s" if version == 3 else ""
    for ability in abilities:
        assert root.find("CoSimulation").get(f"provides{ability}Derivative{plural}") == "true"
