"""Which parameters and inputs change the initial outputs of a model, found by trying."""

from collections.abc import Iterable, Mapping

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
    """Return a value near `given` or anywhere in the range."""
    if v.type == "Boolean":
        return 1.0 - given
    beside = given * 10.0 ** rng.uniform(-0.7, 0.7)
    if v.type == "Real" and given != 0.0 and rng.random() < 0.5 and v.minimum <= beside <= v.maximum:
        return float(beside)
    return random_value(v, rng)


def observed_dependencies(
    model: Model, constants: Array, scenes: Iterable[Mapping[str, float]], rng: np.random.Generator
) -> dict[str, set[str]]:
    """For each output the parameters and inputs that change its initial value, from any of some base points, `scenes`.

    At every base point, other values of each of them are tried in turn.
    """
    table, instance = model.interface, Instance(model, constants)
    knowns, outputs = table.variables[: table.n_parameters + table.n_inputs], table.of("output")
    tolerance = np.array([0.0 if v.type != "Real" else ROUNDING.get(v.unit, 0.0) for v in outputs])
    changed = np.zeros((len(outputs), len(knowns)), dtype=bool)

    def initial_outputs() -> Array | None:
        try:
            instance.initialise()
        except Fault:
            return None
        return instance.outputs.copy()

    for scene in scenes:
        instance.values[:] = table.start
        for name, value in scene.items():
            instance[name] = value
        before = initial_outputs()
        for i, v in enumerate(knowns if before is not None else ()):
            original = instance.values[i]
            for _ in range(2):
                instance.values[i] = another_value(v, original, rng)
                after = initial_outputs()
                if after is not None:
                    rounding = np.maximum(tolerance, 1e-9 * np.maximum(np.abs(before), np.abs(after)))
                    changed[:, i] |= np.abs(after - before) > rounding
            instance.values[i] = original
    return {
        v.name: {known.name for known, change in zip(knowns, row, strict=True) if change}
        for v, row in zip(outputs, changed, strict=True)
    }
