"""Interfaces of FMUs that are not there, for tests of wiring."""

from collections.abc import Iterable

from amb_cosim.cosim.fmu.fmu_interface import FmuInterface, Port


def interface(*ports: Port, **options: bool) -> FmuInterface:
    return FmuInterface("model", "guid", "1", {port.name: port for port in ports}, **options)


def of_reals(inputs: Iterable[str] = (), outputs: Iterable[str] = (), parameters: Iterable[str] = ()) -> FmuInterface:
    """Return the interface of an FMU with Reals of these names."""
    kinds = {"input": inputs, "output": outputs, "parameter": parameters}
    names = [(name, kind) for kind, of_kind in kinds.items() for name in of_kind]
    return interface(*(Port(name, "Real", kind, k) for k, (name, kind) in enumerate(names)))
