"""The assembly as a model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amb_actuator import actuator
from fmi_export.model import Model
from levitated_rotor import KERNELS_FROM
from levitated_rotor.assembly import ROLES, Assembly, Part
from levitated_rotor.faults import fault_sentences
from levitated_rotor.interface import interface_of
from levitated_rotor.levitation import initialise, step
from levitated_rotor.records import n_state, n_work
from rolac_controller import controller
from rolac_controller.control_loop import control_loop_from
from rotor_contact import plant
from rotor_contact.planes import planes_from


def model_for(assembly: Assembly) -> Model:
    """Return the model of an assembly; its constants are those of `constants_of`.

    Raises
    ------
    ValueError
        If inputs that one signal feeds differ, or there are more connections than fault codes.
    """
    interface = interface_of(assembly)
    return Model(
        name="levitated_rotor",
        description="Flexible rotor levitated by magnetic bearings under sampled control, in one: rotor_contact, "
        "amb_actuator and rolac_controller",
        interface=interface,
        initialise=initialise,
        step=step,
        n_state=n_state,
        n_work=n_work,
        packages=("levitated_rotor", *KERNELS_FROM, "fmi_export"),
        faults=fault_sentences(assembly),
        step_size=interface[f"{assembly.parts[0].name}.sample_time"].start,
        layout=assembly.layout(),
    )


def model_from(layout: Mapping[str, Any]) -> Model:
    """Return the model with the layout that `Assembly.layout` wrote."""
    (c, loop), (a, bearings), (p, planes) = (layout["parts"][role] for role in ROLES)
    parts = (
        Part(c, controller.model_for(control_loop_from(loop))),
        Part(a, actuator.model_for(bearings["bearings"])),
        Part(p, plant.model_for(planes_from(planes))),
    )
    signals = {name: tuple(targets) for name, targets in layout["signals"].items()}
    return model_for(Assembly(parts, layout["connections"], signals))
