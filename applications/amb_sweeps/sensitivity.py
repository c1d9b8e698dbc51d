"""Variance-based sensitivity (Sobol indices) of a metric to the variations of a sweep, computed by SALib.

S_i = V(E(Y | X_i)) / V(Y),     S_Ti = 1 - V(E(Y | X_~i)) / V(Y)
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from amb_sweeps.sampling import SAMPLE, SamplePlan, unit_problem

if TYPE_CHECKING:
    import xarray as xr


def sensitivity(design: SamplePlan, results: xr.Dataset, metric: str = "averaged_contact_force") -> xr.Dataset:
    """Return the first-order and total index of each range of a Saltelli sample, with 95 % confidence.

    Raises
    ------
    ValueError
        If the sweep is not a Saltelli sample, there is no such metric, or the metric has no value for one of the runs.
    """
    import xarray as xr
    from SALib.analyze import sobol

    if not design.sampling.startswith("saltelli:") or len(design.axes) > 1:
        raise ValueError(
            f"sensitivities require a saltelli:N sample without other axes; the sampling is {design.sampling}"
        )
    if metric not in results:
        raise ValueError(f"no metric {metric!r}; the sweep has {', '.join(str(name) for name in results.data_vars)}")
    values = np.asarray(results[metric].values, np.float64)
    missing = int(np.isnan(values).sum())
    if missing:
        raise ValueError(f"{missing} of {values.size} runs have no {metric}; the indices require all runs")
    names = [column.name for axis in design.axes if axis.name == SAMPLE for column in axis.columns]
    indices = sobol.analyze(unit_problem(len(names)), values, calc_second_order=False, seed=design.seed or 0)
    if math.isclose(float(np.ptp(values)), 0.0, abs_tol=1e-300):
        raise ValueError(f"{metric} is {values[0]:g} in all runs, so its sensitivity is undefined")
    data = {key: ("parameter", np.asarray(indices[key])) for key in ("S1", "S1_conf", "ST", "ST_conf")}
    return xr.Dataset(data, {"parameter": names}, {"metric": metric, "runs": values.size})
