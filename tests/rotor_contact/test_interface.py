"""The fields that the kernels read are the variables of the table."""

import numpy as np
import pytest

from amb_cosim.model_constants.plant_data import plant
from rotor_contact.shaft.structure import structure_of
from rotor_contact.variables import enumerations
from rotor_contact.variables.enumerations import CONTACT_MODE, IMPACT_LAW
from rotor_contact.variables.signals import SITE_PARAMETERS, inputs_of, outputs_of, parameters_of

MODEL, CONSTANTS = plant()
INTERFACE = MODEL.interface

SITES, BEARINGS = ("rb1", "rb2", "eb1", "eb2"), ("mb1", "mb2")
AXES = [(bearing, axis) for bearing in BEARINGS for axis in "xy"]
RENAMED = {"base_acceleration.x": "base.a_x", "base_acceleration.y": "base.a_y"}


def fields(record, prefix=""):
    """Yield the names of a record's fields, parts separated by dots, and their values."""
    for name in record.dtype.names:
        full = f"{prefix}{name}"
        yield from (
            fields(record[name], f"{full}.") if record[name].dtype.names else [(RENAMED.get(full, full), record[name])]
        )


def parameters(parts):
    for site, values in zip(SITES, parts.sites, strict=True):
        yield from ((f"{site}.{name}", value) for name, value in zip(SITE_PARAMETERS.names, values, strict=True))
    for bearing, record in zip(BEARINGS, parts.bearings, strict=True):
        yield from fields(record, f"{bearing}.")


def inputs(parts):
    for (bearing, axis), record in zip(AXES, parts.axes, strict=True):
        yield f"{bearing}.f_{axis}", record.force
        yield f"{bearing}.k_{axis}{axis}", record.gradient
        yield f"{bearing}.{axis}_ref", record.reference
    for k, record in enumerate(parts.discs, 1):
        yield from fields(record, f"d{k}.")
    for bearing, record in zip(BEARINGS, parts.cores, strict=True):
        yield from fields(record, f"{bearing}.")


def outputs(parts):
    yield from ((f"{b}.{a}", value) for (b, a), value in zip(AXES, parts.displacements, strict=True))
    yield from ((f"s{k}", value) for k, value in enumerate(parts.sensors, 1))
    for site, record in zip(SITES, parts.sites, strict=True):
        yield from fields(record, f"{site}.")


@pytest.mark.parametrize(
    ("causality", "views_of", "repeated"),
    [("parameter", parameters_of, parameters), ("input", inputs_of, inputs), ("output", outputs_of, outputs)],
)
def test_every_field_of_a_record_is_the_variable_of_that_name(causality, views_of, repeated):
    """Views into an array whose numbers are their positions."""
    names = [v.name for v in INTERFACE.of(causality)]
    parts = views_of(np.arange(float(len(names))), structure_of(CONSTANTS))
    claimed = dict([*fields(parts.scalars[0]), *repeated(parts)])
    assert claimed == {name: i for i, name in enumerate(names) if name != "fault_code"}


@pytest.mark.parametrize("kind", [CONTACT_MODE, IMPACT_LAW])
def test_the_names_of_values_are_those_of_the_constants_in_the_code(kind):
    assert [getattr(enumerations, name.upper()) for name in kind.names] == list(range(len(kind.names)))
