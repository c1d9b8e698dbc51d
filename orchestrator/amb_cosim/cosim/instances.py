"""FMU instances that outlive a run: the first run loads them, each one after it resets them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from amb_cosim.cosim.component import FmuComponent, HeldState
from amb_cosim.cosim.fmu_interface import FmuInterface


class Instances:
    """The instance of each component, by its name; after a run that failed the next one loads new ones.

    `generation` is another one as soon as states that they held are lost.
    """

    def __init__(self) -> None:
        self.generation = 0
        self._expired = False
        self._kept: dict[str, tuple[Path, FmuComponent]] = {}

    def take(
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
        while self._kept:
            _, (_, component) = self._kept.popitem()
            component.close()
