"""The positions that the kernels read are those of the table."""

import pytest

from rotor_contact import interface as at
from rotor_contact.interface import INTERFACE

SITES = ("rb1", "rb2", "eb1", "eb2")
SITE_PARAMETERS = {
    "enabled": at.ENABLED,
    "law": at.LAW,
    "clearance": at.CLEARANCE,
    "mu": at.MU,
    "mu_static": at.MU_STATIC,
    "restitution": at.RESTITUTION,
    "journal_radius": at.JOURNAL_RADIUS,
    "offset_x": at.OFFSET_X,
    "offset_y": at.OFFSET_Y,
    "k_c": at.K_C,
    "c_c": at.C_C,
    "delta_c": at.DELTA_C,
    "alpha_c": at.ALPHA_C,
    "eta": at.ETA,
}
SITE_OUTPUTS = {
    "gap": at.Y_GAP,
    "mode": at.Y_MODE,
    "f_n": at.Y_NORMAL,
    "f_t": at.Y_TANGENTIAL,
    "impulse": at.Y_IMPULSE,
    "slip_velocity": at.Y_SLIP,
    "whirl_speed": at.Y_WHIRL,
}


def parameters():
    yield "contact.impact_law", at.IMPACT_LAW
    yield "solver.max_substep", at.MAX_SUBSTEP
    yield "solver.tolerance", at.TOLERANCE
    yield "solver.exact_flight", at.EXACT_FLIGHT
    yield "gravity", at.GRAVITY
    yield "initial.orbit", at.ORBIT
    for k, site in enumerate(SITES):
        for name, position in SITE_PARAMETERS.items():
            yield f"{site}.{name}", at.SITE + k * at.SITE_PARAMETERS + position
    for k, bearing in enumerate(("mb1", "mb2")):
        yield f"{bearing}.k_b", at.BEARING + k * at.BEARING_PARAMETERS + at.STIFFNESS
        yield f"{bearing}.c_b", at.BEARING + k * at.BEARING_PARAMETERS + at.DAMPING


def inputs():
    yield "Omega", at.OMEGA
    yield "Omega_dot", at.OMEGA_DOT
    for k, bearing in enumerate(("mb1", "mb2")):
        for i, axis in enumerate("xy"):
            start = at.AXIS + (2 * k + i) * at.AXIS_INPUTS
            yield f"{bearing}.f_{axis}", start + at.FORCE
            yield f"{bearing}.k_{axis}{axis}", start + at.GRADIENT
            yield f"{bearing}.{axis}_ref", start + at.REFERENCE
    for k in range(4):
        start = at.DISC + k * at.DISC_INPUTS
        yield f"d{k + 1}.u", start + at.UNBALANCE
        yield f"d{k + 1}.phi", start + at.PHASE
        yield f"d{k + 1}.f_x", start + at.DISC_FORCE_X
        yield f"d{k + 1}.f_y", start + at.DISC_FORCE_Y
    for k, bearing in enumerate(("mb1", "mb2")):
        yield f"{bearing}.u", at.CORE + k * at.CORE_INPUTS + at.UNBALANCE
        yield f"{bearing}.phi", at.CORE + k * at.CORE_INPUTS + at.PHASE
    yield "base.a_x", at.BASE
    yield "base.a_y", at.BASE + 1


def outputs():
    yield "theta", at.THETA
    for i, name in enumerate(("mb1.x", "mb1.y", "mb2.x", "mb2.y")):
        yield name, at.DISPLACEMENT + i
    for i in range(8):
        yield f"s{i + 1}", at.SENSOR + i
    for k, site in enumerate(SITES):
        for name, position in SITE_OUTPUTS.items():
            yield f"{site}.{name}", at.SITE_OUTPUT + k * at.SITE_OUTPUTS + position
    yield "contact_state", at.CONTACT_STATE
    yield "energy.kinetic", at.KINETIC
    yield "energy.strain", at.STRAIN
    for i, name in enumerate(("damping", "friction", "impact")):
        yield f"energy.{name}", at.HEAT + i
    yield "energy.dissipated", at.DISSIPATED
    yield "energy.work", at.WORK
    yield "energy.balance", at.BALANCE


@pytest.mark.parametrize("causality", ["parameter", "input", "output"])
def test_every_position_constant_names_its_variable(causality):
    claimed = {"parameter": parameters, "input": inputs, "output": outputs}[causality]()
    names = [v.name for v in INTERFACE.of(causality)]
    assert dict(claimed) == {name: i for i, name in enumerate(names) if name != "fault_code"}


def test_modes_and_laws_have_the_numbers_that_the_table_documents():
    assert INTERFACE["rb1.mode"].description.startswith(f"{at.FREE} free, {at.SLIDING} sliding, {at.ROLLING} rolling")
    laws = [f"{getattr(at, name.upper())} {name}" for name in at.LAWS]
    assert INTERFACE["eb2.law"].description.endswith(": " + ", ".join(laws))
    assert f"{at.NODAL} nodal" in INTERFACE["contact.impact_law"].description
    assert f"{at.NEWTON} newton" in INTERFACE["contact.impact_law"].description
