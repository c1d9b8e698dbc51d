"""The fields that the kernels read are the variables of the table."""

import numpy as np
import pytest

from amb_cosim.design.plant_data import plant
from rotor_contact import enumerations
from rotor_contact.enumerations import CONTACT_LAW, CONTACT_MODE, IMPACT_LAW
from rotor_contact.signals import SITE_OUTPUTS, SITE_PARAMETERS, inputs_of, outputs_of, parameters_of
from rotor_contact.structure import structure_of

MODEL, CONSTANTS = plant()
INTERFACE = MODEL.interface

SITES = ("rb1", "rb2", "eb1", "eb2")
BEARINGS = ("mb1", "mb2")


def numbered(views_of, causality):
    """Views into an array whose numbers are their positions, and its record of what stands alone."""
    views = views_of(np.arange(float(len(INTERFACE.of(causality)))), structure_of(CONSTANTS))
    return views, views.own[0]


def parameters():
    parts, p = numbered(parameters_of, "parameter")
    yield "contact.impact_law", p.contact.impact_law
    yield "solver.max_substep", p.solver.max_substep
    yield "solver.tolerance", p.solver.tolerance
    yield "solver.energy_limit", p.solver.energy_limit
    yield "solver.exact_motion", p.solver.exact_motion
    yield "gravity", p.gravity
    yield "gravity_angle", p.gravity_angle
    yield "ambient_temperature", p.ambient_temperature
    yield "spin.free", p.spin.free
    yield "spin.inertia", p.spin.inertia
    yield "spin.drag", p.spin.drag
    yield "drive.gain", p.drive.gain
    yield "initial.orbit", p.initial.orbit
    for k, site in enumerate(SITES):
        for name, value in zip(SITE_PARAMETERS.names, parts.sites[k], strict=True):
            yield f"{site}.{name}", value
    for k, bearing in enumerate(BEARINGS):
        yield f"{bearing}.k_b", parts.bearings[k].k_b
        yield f"{bearing}.c_b", parts.bearings[k].c_b


def inputs():
    parts, u = numbered(inputs_of, "input")
    yield "Omega", u.Omega
    yield "Omega_dot", u.Omega_dot
    yield "drive.torque", u.drive.torque
    yield "drive.torque_limit", u.drive.torque_limit
    for k, bearing in enumerate(BEARINGS):
        for i, axis in enumerate("xy"):
            yield f"{bearing}.f_{axis}", parts.axes[2 * k + i].force
            yield f"{bearing}.k_{axis}{axis}", parts.axes[2 * k + i].gradient
            yield f"{bearing}.{axis}_ref", parts.axes[2 * k + i].reference
    for k in range(4):
        for name in ("u", "phi", "f_x", "f_y"):
            yield f"d{k + 1}.{name}", parts.discs[k][name]
    for k, bearing in enumerate(BEARINGS):
        yield f"{bearing}.u", parts.cores[k].u
        yield f"{bearing}.phi", parts.cores[k].phi
    yield "base.a_x", u.base_acceleration.x
    yield "base.a_y", u.base_acceleration.y


def outputs():
    parts, y = numbered(outputs_of, "output")
    yield "theta", y.theta
    yield "speed", y.speed
    yield "solver.tolerance_missed", y.solver.tolerance_missed
    yield "solver.energy_missed", y.solver.energy_missed
    for k, bearing in enumerate(BEARINGS):
        yield f"{bearing}.x", parts.displacements[2 * k]
        yield f"{bearing}.y", parts.displacements[2 * k + 1]
    for i in range(8):
        yield f"s{i + 1}", parts.sensors[i]
    for k, site in enumerate(SITES):
        for name in SITE_OUTPUTS.names:
            yield f"{site}.{name}", parts.sites[k][name]
    yield "contact_state", y.contact_state
    for name in ("kinetic", "strain", "damping", "friction", "impact", "dissipated", "work", "balance"):
        yield f"energy.{name}", y.energy[name]


@pytest.mark.parametrize("causality", ["parameter", "input", "output"])
def test_every_field_of_a_record_is_the_variable_of_that_name(causality):
    claimed = {"parameter": parameters, "input": inputs, "output": outputs}[causality]()
    names = [v.name for v in INTERFACE.of(causality)]
    assert dict(claimed) == {name: i for i, name in enumerate(names) if name != "fault_code"}


@pytest.mark.parametrize("kind", [CONTACT_MODE, CONTACT_LAW, IMPACT_LAW])
def test_the_names_of_values_are_those_of_the_constants_in_the_code(kind):
    assert [getattr(enumerations, name.upper()) for name in kind.names] == list(range(len(kind.names)))
