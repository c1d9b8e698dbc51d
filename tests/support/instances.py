"""Instances of models with values by name."""

from collections.abc import Mapping

from fmi_export.model import Array, Instance, Model


def initialised(model: Model, constants: Array, values: Mapping[str, float]) -> Instance:
    """Return an instance that was initialised with these parameters and inputs."""
    instance = Instance(model, constants)
    for name, value in values.items():
        instance[name] = value
    instance.initialise()
    return instance
