"""The plant's methods of computing its steps, from a data set."""

from __future__ import annotations

import numpy as np

from amb_cosim.cosim.record.signals import Signals
from amb_cosim.results.series import at_every_step, cycles, flags, signal


def shares_of_steps(dataset: Signals) -> dict[str, float] | None:
    """Return the share of the steps from cycle 0 on that the plant computed by each method that occurs.

    Names are those of the plant's output `solver.method`; None if it was not recorded, or cycle 0 was not reached.
    """
    names, dataset = flags(dataset, "solver.method"), at_every_step(dataset)
    methods = signal(dataset, "solver.method")
    if methods is None or names is None:
        return None
    result = methods[cycles(dataset) >= 0.0]
    if not len(result):
        return None
    shares = {name: float(np.mean(result == value)) for value, name in names.items()}
    return {name: share for name, share in shares.items() if share > 0.0}
