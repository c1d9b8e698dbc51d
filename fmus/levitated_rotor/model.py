"""An assembly as a model."""

from __future__ import annotations

from typing import NoReturn

from fmi_export.model import Model
from levitated_rotor.assembly import Composite
from levitated_rotor.interface import interface_of

FAULTS = {1: "outputs do not settle during initialisation; the connections close an algebraic loop"}


def no_kernel(*_: object) -> NoReturn:
    """Raise NotImplementedError, because only `assembly.c` in the FMU can step the parts of an assembly."""
    raise NotImplementedError("an assembly has no kernels of its own; build its FMU")


def model_for(composite: Composite, name: str, description: str) -> Model:
    """Return the model of an assembly; its constants are those of its parts, in order.

    Raises
    ------
    ValueError
        If inputs that share a signal have different types or units, or there are too many parts.
    """
    interface = interface_of(composite)
    packages = [package for part in composite.parts for package in part.model.packages]
    return Model(
        name=name,
        description=description,
        author="The amb-cosim authors",
        interface=interface,
        initialise=no_kernel,
        step=no_kernel,
        n_state=0,
        n_work=0,
        packages=tuple(dict.fromkeys(("levitated_rotor", *packages))),
        faults=FAULTS,
        variable_step=all(part.model.variable_step for part in composite.parts),
        step_size=composite.step_size,
        parts=composite.parts,
        wiring=composite.wiring(),
    )
