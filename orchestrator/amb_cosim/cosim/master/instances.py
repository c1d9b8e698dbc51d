"""FMU instances that outlive a run: the first run loads them, each one after it resets them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import Structure
from pathlib import Path
from typing import Any

import numpy as np

from amb_cosim.cosim.basics.schedules import Array, IntArray
from amb_cosim.cosim.fmu.component import FmuComponent, HeldState
from amb_cosim.cosim.fmu.fmu_interface import FmuInterface
from amb_cosim.cosim.master.compiled import program_of
from amb_cosim.cosim.master.master import Master
from amb_cosim.cosim.system.stopping import StopObserver


class InstancePool:
    """The instance of each component, by its name; after a run that failed the next one loads new ones.

    `generation` is another one as soon as states that they held are lost.
    """

    def __init__(self) -> None:
        self.generation = 0
        self._expired = False
        self._kept: dict[str, tuple[Path, FmuComponent]] = {}
        self._values: dict[tuple[str, ...], Array] = {}
        self._programs: dict[tuple[Any, ...], Structure] = {}

    def values(self, names: tuple[str, ...]) -> Array:
        """Return an array, all zero, for the values of signals of these names: that of the run before with the same."""
        values = self._values.setdefault(names, np.zeros(len(names)))
        values[:] = 0.0
        return values

    def program(self, master: Master[FmuComponent], stops: StopObserver, each: IntArray) -> Structure:
        """Return the `program_of` a master of these instances; of one that differs in nothing it is the same."""
        every = tuple(component.every for component in master.components)
        judged = tuple(stops.conditions.positions.tolist()), tuple(each.tolist())
        key = master.values.ctypes.data, master.wiring.names, master.coupling, master.step_size, every, judged
        if key not in self._programs:
            self._programs[key] = program_of(master, stops, each)
        return self._programs[key]

    def acquire(
        self,
        name: str,
        folder: Path,
        interface: FmuInterface,
        inputs: Sequence[str],
        outputs: Sequence[str],
        start: Mapping[str, float],
        every: int,
    ) -> FmuComponent:
        """Return the instance of a component as new; see `FmuComponent` for the arguments and errors."""
        if self._expired:
            self.close()
        kept_folder, component = self._kept.get(name, (None, None))
        if component is not None and kept_folder == folder:
            component.reset(inputs, outputs, start, every)
            return component
        if component is not None:
            self.generation += 1
            component.close()
            self._programs.clear()
        component = FmuComponent(name, folder, interface, inputs, outputs, start, every)
        self._kept[name] = (folder, component)
        return component

    def expire(self) -> None:
        """Have no run reset these instances; they are freed when the next one asks for some, or by `close`."""
        self._expired = True
        self.generation += 1

    def forget(self, states: Mapping[str, object]) -> None:
        """Free states that the instances of this generation hold, by component."""
        for name, state in states.items():
            if isinstance(state, HeldState):
                self._kept[name][1].forget(state)

    def close(self) -> None:
        """Free all instances; they are loaded again when they are asked for."""
        self._expired = False
        self.generation += 1
        self._programs.clear()
        while self._kept:
            _, (_, component) = self._kept.popitem()
            component.close()
