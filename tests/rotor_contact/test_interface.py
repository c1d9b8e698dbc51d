"""The positions that the kernels read are those of the table."""

import pytest

from rotor_contact import interface as at
from rotor_contact.interface import INTERFACE

SITE_PARAMETERS = {
    "clearance": at.CLEARANCE,
    "mu": at.MU,
    "restitution": at.RESTITUTION,
    "journal_radius": at.JOURNAL_RADIUS,
    "offset_x": at.OFFSET_X,
    "offset_y": at.OFFSET_Y,
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
    for k, site in enumerate(("rb1", "rb2")):
        for name, position in SITE_PARAMETERS.items():
            yield f"{site}.{name}", at.SITE + k * at.SITE_PARAMETERS + position
    for k, bearing in enumerate(("mb1", "mb2")):
        yield f"{bearing}.k_b", at.BEARING + k * at.BEARING_PARAMETERS + at.STIFFNESS
        yield f"{bearing}.c_b", at.BEARING + k * at.BEARING_PARAMETERS + at.DAMPING


def inputs():
    yield "Omega", at.OMEGA
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
    yield "base.a_x", at.BASE
    yield "base.a_y", at.BASE + 1


def outputs():
    yield "theta", at.THETA
    for i, name in enumerate(("mb1.x", "mb1.y", "mb2.x", "mb2.y")):
        yield name, at.DISPLACEMENT + i
    for i in range(8):
        yield f"s{i + 1}", at.SENSOR + i
    for k, site in enumerate(("rb1", "rb2")):
        for name, position in SITE_OUTPUTS.items():
            yield f"{site}.{name}", at.SITE_OUTPUT + k * at.SITE_OUTPUTS + position
    yield "contact_state", at.CONTACT_STATE
    yield "energy.kinetic", at.KINETIC
    yield "energy.strain", at.STRAIN
    yield "energy.dissipated", at.DISSIPATED


@pytest.mark.parametrize("causality", ["parameter", "input", "output"])
def test_every_position_constant_names_its_variable(causality):
    claimed = {"parameter": parameters, "input": inputs, "output": outputs}[causality]()
    names = [v.name for v in INTERFACE.of(causality)]
    assert dict(claimed) == {name: i for i, name in enumerate(names) if name != "fault_code"}


def test_modes_and_laws_have_the_numbers_that_the_table_documents():
    assert INTERFACE["rb1.mode"].description.startswith(f"{at.FREE} free, {at.SLIDING} sliding, {at.ROLLING} rolling")
    assert f"{at.NODAL} nodal" in INTERFACE["contact.impact_law"].description
    assert f"{at.NEWTON} newton" in INTERFACE["contact.impact_law"].description
