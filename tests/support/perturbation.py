"""Which parameters and inputs change the initial outputs of a model, found by trying."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fmi_export.model import Array, Fault, Instance, Model
from fmi_export.variables import Variable

# Sizes that values of a unit have, as powers of ten; from one to the other lie all regimes of the models.
DECADES = {
    "m": (-5, -2.5),
    "m2": (-5, -3),
    "rad": (-2, 0.5),
    "rad/s": (-1, 3),
    "s": (-6, -2),
    "1/s": (-1, 4),
    "kg": (-2, 2),
    "kg.m": (-5, -1),
    "kg.m2": (-4, 1),
    "m/s": (-4, 1),
    "m/s2": (-1, 3),
    "N": (0, 5),
    "N.m": (-1, 4),
    "N.m.s": (-2, 4),
    "N/m": (4, 9),
    "N.s/m": (1, 6),
    "N/A": (1, 4),
    "A": (-1, 1.5),
    "A/V": (-2, 1),
    "V": (-1, 3),
    "V/m": (2, 5),
    "T": (-2, 1),
    "H": (-3, 0),
    "Ohm": (-2, 1),
    "K": (1, 3),
    "Hz": (0, 4),
}
# Changes below these are rounding: residual slip of 1e-9 m/s, a penetration of 1e-19 m under a stiff law.
ROUNDING = {"N": 1e-2, "W": 1e-2, "m/s": 1e-7, "rad/s": 1e-3, "J": 1e-8, "m": 1e-13}


def random_value(v: Variable, rng: np.random.Generator) -> float:
    """A value that a variable may have, of any size."""
    if v.type == "Boolean":
        return float(rng.integers(2))
    if v.type == "Integer":
        return min(v.minimum + float(rng.geometric(0.3)) - 1.0, v.maximum)
    low, high = DECADES.get(v.unit, (-2, 2))
    value = 10.0 ** rng.uniform(low, high) * (1.0 if v.minimum >= 0.0 else rng.choice([-1.0, 1.0]))
    return value if v.minimum <= value <= v.maximum else 0.0 if v.minimum <= 0.0 <= v.maximum else v.minimum


def another_value(v: Variable, given: float, rng: np.random.Generator) -> float:
    """A value beside the one given or anywhere else."""
    if v.type == "Boolean":
        return 1.0 - given
    beside = given * 10.0 ** rng.uniform(-0.7, 0.7)
    if v.type == "Real" and given != 0.0 and rng.random() < 0.5 and v.minimum <= beside <= v.maximum:
        return float(beside)
    return random_value(v, rng)


class Edge(NamedTuple):
    """Where a discrete output switches: all values, the known that was changed, and its value on the other side."""

    values: Array
    known: int
    outside: float


class Trials:
    """A model that is initialised again and again, and which of its knowns have changed which of its outputs."""

    def __init__(self, model: Model, constants: Array, rng: np.random.Generator) -> None:
        self.table, self.rng, self.instance = model.interface, rng, Instance(model, constants)
        self.n_known = self.table.n_parameters + self.table.n_inputs
        self.outputs = self.table.of("output")
        self.tolerance = np.array([0.0 if v.type != "Real" else ROUNDING.get(v.unit, 0.0) for v in self.outputs])
        self.changed = np.zeros((len(self.outputs), self.n_known), dtype=bool)
        self.edges: dict[int, list[Edge]] = {k: [] for k, v in enumerate(self.outputs) if v.type != "Real"}

    def start(self, scene: Mapping[str, float]) -> Array | None:
        """Set a base point, values that differ from the start values, and return its outputs."""
        self.instance.values[:] = self.table.start
        for name, value in scene.items():
            self.instance[name] = value
        return self.initial_outputs()

    def initial_outputs(self) -> Array | None:
        try:
            self.instance.initialise()
        except Fault:
            return None
        return self.instance.outputs.copy()

    def outputs_with(self, known: int, value: float) -> Array | None:
        values, self.instance.values[known] = self.instance.values[known], value
        after = self.initial_outputs()
        self.instance.values[known] = values
        return after

    def perturb(self, before: Array, knowns: Iterable[int], times: int = 2) -> None:
        """Try other values of some knowns, one after the other, at the present base point."""
        for i in knowns:
            v = self.table.variables[i]
            for _ in range(times):
                value = another_value(v, self.instance.values[i], self.rng)
                after = self.outputs_with(i, value)
                if after is None:
                    continue
                rounding = np.maximum(self.tolerance, 1e-9 * np.maximum(np.abs(before), np.abs(after)))
                self.changed[:, i] |= np.abs(after - before) > rounding
                for output, edges in self.edges.items():
                    if v.type == "Real" and after[output] != before[output]:
                        edges.append(Edge(self.instance.values.copy(), i, value))

    def go_to(self, edge: Edge, output: int) -> Array | None:
        """Move the base point to an edge, so near that any other change switches the output too; return the outputs."""
        self.instance.values[:] = edge.values
        inside, outside = edge.values[edge.known], edge.outside
        before = self.initial_outputs()
        for _ in range(20):
            middle = 0.5 * (inside + outside)
            after = self.outputs_with(edge.known, middle)
            if before is not None and after is not None and after[output] == before[output]:
                inside = middle
            else:
                outside = middle
        self.instance.values[edge.known] = self.rng.choice([inside, outside])
        return self.initial_outputs()


def observed_dependencies(
    model: Model, constants: Array, scenes: Iterable[Mapping[str, float]], rng: np.random.Generator, n_edges: int = 300
) -> dict[str, set[str]]:
    """For each output the parameters and inputs that change its initial value, from any of some base points.

    At every base point, a scene, all knowns are tried. A discrete output changes only near an edge, so base points on
    edges found so, up to `n_edges` for each output, follow; what should change it there and has not yet is tried.
    """
    trials = Trials(model, constants, rng)
    for scene in scenes:
        before = trials.start(scene)
        if before is not None:
            trials.perturb(before, range(trials.n_known))
    position = model.interface.position
    for output, edges in trials.edges.items():
        declared = [position[name] for name in model.interface.initial_dependencies[trials.outputs[output].name]]
        for edge in _in_turn(edges, rng)[:n_edges]:
            unseen = [i for i in declared if not trials.changed[output, i]]
            at_edge = trials.go_to(edge, output) if unseen else None
            if at_edge is not None:
                trials.perturb(at_edge, unseen)
    names = [v.name for v in model.interface.variables[: trials.n_known]]
    return {
        v.name: {name for name, change in zip(names, row, strict=True) if change}
        for v, row in zip(trials.outputs, trials.changed, strict=True)
    }


def _in_turn(edges: Sequence[Edge], rng: np.random.Generator) -> list[Edge]:
    """Edges in random order, those of each known in turn: most are of the few that change everything."""
    rounds: dict[int, int] = {}
    ordered = []
    for k in rng.permutation(len(edges)):
        rounds[edges[k].known] = rounds.get(edges[k].known, 0) + 1
        ordered.append((rounds[edges[k].known], edges[k].known, k))
    return [edges[k] for _, _, k in sorted(ordered)]
