"""FMU instances that outlive a run: the first run loads them, and later runs reset them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from amb_cosim.cosim.fmu.component import FmuComponent, HeldState, StartValues
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.fmu.separate_component import SeparateComponent
from amb_cosim.cosim.master.compiled import Programs
from array_types import Array


class InstancePool:
    """The loaded instances of components, by name; after a failed run, the next run loads new instances.

    `generation` changes when the states held by the instances are lost; `programs` belong to the compiled loop.
    """

    def __init__(self) -> None:
        self.generation = 0
        self._expired = False
        self._loaded: dict[str, tuple[Path, FmuComponent]] = {}
        self._values: dict[tuple[str, ...], Array] = {}
        self.programs: Programs = {}

    def values(self, names: tuple[str, ...]) -> Array:
        """Return an array of zeros for these signals; the array of an earlier run with the same names is reused."""
        values = self._values.setdefault(names, np.zeros(len(names)))
        values[:] = 0.0
        return values

    def acquire(
        self,
        name: str,
        folder: Path,
        interface: FmuInterface,
        inputs: Sequence[str],
        outputs: Sequence[str],
        start: StartValues,
        every: int,
        is_separate: bool = False,
    ) -> FmuComponent:
        """Return a new or reset instance of a component; see `FmuComponent` for arguments and errors.

        With `is_separate`, the instance runs in a separate process.
        """
        if self._expired:
            self.close()
        loaded_folder, component = self._loaded.get(name, (None, None))
        is_of_kind = isinstance(component, SeparateComponent) == is_separate
        if component is not None and loaded_folder == folder and is_of_kind:
            component.reset(inputs, outputs, start, every)
            return component
        if component is not None:
            self.generation += 1
            component.close()
            self.programs.clear()
        kind = SeparateComponent if is_separate else FmuComponent
        component = kind(name, folder, interface, inputs, outputs, start, every)
        self._loaded[name] = (folder, component)
        return component

    def expire(self) -> None:
        """Mark these instances as not reusable; the next request for instances, or `close`, frees them."""
        self._expired = True
        self.generation += 1

    def forget(self, states: Mapping[str, object]) -> None:
        """Free the states, given by component, that the instances of this generation hold."""
        for name, state in states.items():
            if isinstance(state, HeldState):
                self._loaded[name][1].forget(state)

    def close(self) -> None:
        """Free all instances; they are loaded again when they are requested."""
        self._expired = False
        self.generation += 1
        self.programs.clear()
        while self._loaded:
            _, (_, component) = self._loaded.popitem()
            component.close()
